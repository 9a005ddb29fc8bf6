#include "worker/optimisation/frame_covariances.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/covariance_between.hpp"
#include "worker/optimisation/follow_keyframes.hpp"
#include "worker/optimisation/motion_variances.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/ratio.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::optimisation {
namespace {

constexpr double kMedianOfThree = stats::kMedianNormOfThree * stats::kMedianNormOfThree;

// The frames from one keyframe to the next, and the odometry's error over them.
struct Interval {
    std::size_t from = 0;
    std::size_t to = 0;
    MotionVariance missed;
    std::vector<MotionVariance> stated;  // of the odometry, from `from` up to each frame
};

std::vector<Interval> intervals(const types::Trajectory& odometry,
                                const std::vector<types::MotionSigma>& sigmas,
                                const std::vector<types::Keyframe>& keyframes,
                                const Eigen::Isometry3d& T_imu_cam) {
    std::vector<Interval> result;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        if (keyframes[k].segment != keyframes[k - 1].segment) continue;
        Interval interval{frame_at(odometry, keyframes[k - 1].timestamp_ns),
                          frame_at(odometry, keyframes[k].timestamp_ns),
                          {},
                          {}};
        interval.stated = summed_variances(sigmas, interval.from, interval.to);
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

// Returns the variance of the odometry's errors over the one that it states; 1 if it states none.
MotionVariance variance_ratio(const std::vector<Interval>& intervals) {
    const auto typical = [&](double MotionVariance::*part) {
        std::vector<double> ratios;
        ratios.reserve(intervals.size());
        for (const Interval& interval : intervals)
            if (interval.stated.back().*part > 0.0)
                ratios.push_back(interval.missed.*part / interval.stated.back().*part);
        if (ratios.empty()) return 1.0;
        return stats::upper_median(std::move(ratios)) * 3.0 / kMedianOfThree;
    };
    return {typical(&MotionVariance::position_m2), typical(&MotionVariance::rotation_rad2)};
}

MotionVariance scaled(const MotionVariance& ratio, const MotionVariance& of) {
    return {ratio.position_m2 * of.position_m2, ratio.rotation_rad2 * of.rotation_rad2};
}

MotionVariance difference(const MotionVariance& a, const MotionVariance& b) {
    return {a.position_m2 - b.position_m2, a.rotation_rad2 - b.rotation_rad2};
}

// Returns the variance of a Brownian bridge over an error of variance `whole`, where the steps have
// done `done` of `stated`.
MotionVariance of_bridge(const MotionVariance& whole,
                         const MotionVariance& done,
                         const MotionVariance& stated) {
    const auto at = [](double variance, double part, double sum) {
        const double share = stats::ratio(part, sum);
        return variance * share * (1.0 - share);
    };
    return {at(whole.position_m2, done.position_m2, stated.position_m2),
            at(whole.rotation_rad2, done.rotation_rad2, stated.rotation_rad2)};
}

}  // namespace

types::CovarianceTrack covariances_at(const types::CovarianceTrack& covariances,
                                      const types::Trajectory& odometry,
                                      const std::vector<types::MotionSigma>& sigmas,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam,
                                      const types::Breaks& breaks_ns) {
    types::CovarianceTrack result;
    if (covariances.empty()) return result;
    for (const types::StampedPose& frame : odometry)
        result.push_back(covariance_between(covariances, frame.timestamp_ns));
    const auto add = [&](std::size_t frame, const MotionVariance& variance) {
        result[frame].position_m2.diagonal().array() += variance.position_m2;
        result[frame].rotation_rad2.diagonal().array() += variance.rotation_rad2;
    };
    const auto tied = intervals(odometry, sigmas, keyframes, T_imu_cam);
    const MotionVariance ratio = variance_ratio(tied);
    // What nothing measured is no better than stated, however good the rest is.
    const MotionVariance beyond{std::max(1.0, ratio.position_m2),
                                std::max(1.0, ratio.rotation_rad2)};
    for (const Interval& interval : tied) {
        const MotionVariance& stated = interval.stated.back();
        const Ties ties = ties_between(odometry, breaks_ns, interval.from, interval.to);
        const MotionVariance whole{
            std::max(ratio.position_m2 * stated.position_m2, interval.missed.position_m2),
            std::max(ratio.rotation_rad2 * stated.rotation_rad2, interval.missed.rotation_rad2)};
        for (std::size_t i = interval.from + 1; i < interval.to; ++i) {
            const MotionVariance& done = interval.stated[i - interval.from];
            if (ties.broken && i < ties.end_of_first)
                add(i, scaled(beyond, done));
            else if (ties.broken && i >= ties.begin_of_second)
                add(i, scaled(beyond, difference(stated, done)));
            else
                add(i, of_bridge(whole, done, stated));
        }
    }
    const std::size_t last = frame_at(odometry, keyframes.back().timestamp_ns);
    const auto after = summed_variances(sigmas, last, odometry.size() - 1);
    for (std::size_t i = last; i < odometry.size(); ++i) add(i, scaled(beyond, after[i - last]));
    return result;
}

}  // namespace divemesh::optimisation
