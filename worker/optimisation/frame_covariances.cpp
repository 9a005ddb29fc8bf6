#include "worker/optimisation/frame_covariances.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/covariance_between.hpp"
#include "worker/optimisation/follow_keyframes.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::optimisation {
namespace {

constexpr double kMedianOfThree = stats::kMedianNormOfThree * stats::kMedianNormOfThree;

// Variances per axis.
struct Variance {
    double position_m2 = 0.0;
    double rotation_rad2 = 0.0;
};

// The frames from one keyframe to the next, and the odometry's error over them.
struct Interval {
    std::size_t from = 0;
    std::size_t to = 0;
    Variance missed;
    std::vector<double> steps;  // in which the odometry moves, from `from` up to each frame

    double num_steps() const { return std::max(1.0, steps.back()); }
};

// Returns the number of steps in which the odometry moves, from one frame up to each later one.
std::vector<double> moving_steps(const types::Trajectory& odometry,
                                 std::size_t from,
                                 std::size_t to) {
    std::vector<double> steps = {0.0};
    for (std::size_t i = from + 1; i <= to; ++i)
        steps.push_back(steps.back() + (moves_to(odometry, i) ? 1.0 : 0.0));
    return steps;
}

std::vector<Interval> intervals(const types::Trajectory& odometry,
                                const std::vector<types::Keyframe>& keyframes,
                                const Eigen::Isometry3d& T_imu_cam) {
    std::vector<Interval> result;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        if (keyframes[k].segment != keyframes[k - 1].segment) continue;
        Interval interval{frame_at(odometry, keyframes[k - 1].timestamp_ns),
                          frame_at(odometry, keyframes[k].timestamp_ns),
                          {},
                          {}};
        interval.steps = moving_steps(odometry, interval.from, interval.to);
        const Eigen::Isometry3d T_cam_imu = T_imu_cam.inverse();
        const Eigen::Isometry3d T_from_to = (keyframes[k - 1].T_world_cam * T_cam_imu).inverse() *
                                            (keyframes[k].T_world_cam * T_cam_imu);
        const Eigen::Isometry3d missed = T_from_to.inverse() *
                                         odometry[interval.from].T_world_imu.inverse() *
                                         odometry[interval.to].T_world_imu;
        const double turned_rad = base::angle_rad(missed.linear());
        interval.missed = {missed.translation().squaredNorm() / 3.0, turned_rad * turned_rad / 3.0};
        result.push_back(interval);
    }
    return result;
}

// Returns the variance of one step from frame to frame.
Variance step_variance(const std::vector<Interval>& intervals) {
    const auto typical = [&](double Variance::*part) {
        std::vector<double> values;
        values.reserve(intervals.size());
        for (const Interval& interval : intervals)
            values.push_back(interval.missed.*part / interval.num_steps());
        return stats::upper_median(std::move(values)) * 3.0 / kMedianOfThree;
    };
    return {typical(&Variance::position_m2), typical(&Variance::rotation_rad2)};
}

}  // namespace

types::CovarianceTrack covariances_at(const types::CovarianceTrack& covariances,
                                      const types::Trajectory& odometry,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam,
                                      const types::Breaks& breaks_ns) {
    types::CovarianceTrack result;
    if (covariances.empty()) return result;
    for (const types::StampedPose& frame : odometry)
        result.push_back(covariance_between(covariances, frame.timestamp_ns));
    const auto add = [&](std::size_t frame, const Variance& variance, double times) {
        result[frame].position_m2.diagonal().array() += times * variance.position_m2;
        result[frame].rotation_rad2.diagonal().array() += times * variance.rotation_rad2;
    };
    const auto tied = intervals(odometry, keyframes, T_imu_cam);
    const Variance step = step_variance(tied);
    for (const Interval& interval : tied) {
        const double num = interval.num_steps();
        const Ties ties = ties_between(odometry, breaks_ns, interval.from, interval.to);
        const Variance whole{std::max(num * step.position_m2, interval.missed.position_m2),
                             std::max(num * step.rotation_rad2, interval.missed.rotation_rad2)};
        for (std::size_t i = interval.from + 1; i < interval.to; ++i) {
            if (ties.broken && (i < ties.end_of_first || i >= ties.begin_of_second)) {
                const double done = interval.steps[i - interval.from];
                add(i, step, i < ties.end_of_first ? done : interval.steps.back() - done);
                continue;
            }
            const double share = interval.steps[i - interval.from] / num;
            add(i, whole, share * (1.0 - share));
        }
    }
    const std::size_t last = frame_at(odometry, keyframes.back().timestamp_ns);
    for (std::size_t i = last; i < odometry.size(); ++i)
        add(i, step, static_cast<double>(i - last));
    return result;
}

}  // namespace divemesh::optimisation
