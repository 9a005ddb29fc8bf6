#include "worker/optimisation/follow_keyframes.hpp"

#include <algorithm>
#include <iterator>

#include "worker/optimisation/motion_variances.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::optimisation {
namespace {

// Returns the pose between `a` and `b` that has the share of their difference that the variance
// `done` has of `whole`.
Eigen::Isometry3d blend(const Eigen::Isometry3d& a,
                        const Eigen::Isometry3d& b,
                        const MotionVariance& done,
                        const MotionVariance& whole) {
    const double turned = stats::ratio(done.rotation_rad2, whole.rotation_rad2);
    const double moved = stats::ratio(done.position_m2, whole.position_m2);
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = Eigen::Quaterniond(a.linear())
                          .slerp(turned, Eigen::Quaterniond(b.linear()))
                          .normalized()
                          .toRotationMatrix();
    result.translation() = (1.0 - moved) * a.translation() + moved * b.translation();
    return result;
}

}  // namespace

std::size_t frame_at(const types::Trajectory& frames, std::int64_t timestamp_ns) {
    const auto found = std::lower_bound(
        frames.begin(),
        frames.end(),
        timestamp_ns,
        [](const types::StampedPose& pose, std::int64_t time) { return pose.timestamp_ns < time; });
    return static_cast<std::size_t>(found - frames.begin());
}

Ties ties_between(const types::Trajectory& odometry,
                  const types::Breaks& breaks_ns,
                  std::size_t from,
                  std::size_t to) {
    Ties ties{to, from, false};
    for (std::size_t i = from + 1; i <= to && i < odometry.size(); ++i) {
        if (!types::is_break(breaks_ns, odometry[i].timestamp_ns)) continue;
        if (!ties.broken) ties.end_of_first = i;
        ties.begin_of_second = i;
        ties.broken = true;
    }
    return ties;
}

types::Trajectory follow_keyframes(const types::Trajectory& odometry,
                                   const std::vector<types::MotionSigma>& sigmas,
                                   const std::vector<types::Keyframe>& keyframes,
                                   const Eigen::Isometry3d& T_imu_cam,
                                   const types::Breaks& breaks_ns) {
    types::Trajectory result = odometry;
    for (std::size_t k = 0; k < keyframes.size(); ++k) {
        const bool last = k + 1 == keyframes.size();
        const bool ends = last || keyframes[k + 1].segment != keyframes[k].segment;
        const std::size_t from = frame_at(odometry, keyframes[k].timestamp_ns);
        const std::size_t to =
            last ? odometry.size() : frame_at(odometry, keyframes[k + 1].timestamp_ns);
        const Ties ties = ties_between(odometry, breaks_ns, from, to);
        const Eigen::Isometry3d T_world_from = keyframes[k].T_world_cam * T_imu_cam.inverse();
        const std::vector<MotionVariance> errors =
            last ? std::vector<MotionVariance>() : summed_variances(sigmas, from, to);
        for (std::size_t i = k == 0 ? 0 : from; i < to; ++i) {
            const Eigen::Isometry3d forward =
                T_world_from * odometry[from].T_world_imu.inverse() * odometry[i].T_world_imu;
            result[i].T_world_imu = forward;
            const bool tied_to_next = !last && ties.broken && i >= ties.begin_of_second;
            if ((ends && !tied_to_next) || i < from) continue;
            if (ties.broken && i < ties.end_of_first) continue;
            const Eigen::Isometry3d backward = keyframes[k + 1].T_world_cam * T_imu_cam.inverse() *
                                               odometry[to].T_world_imu.inverse() *
                                               odometry[i].T_world_imu;
            result[i].T_world_imu =
                tied_to_next ? backward : blend(forward, backward, errors[i - from], errors.back());
        }
    }
    return result;
}

std::vector<types::Keyframe> posed_by(const types::Trajectory& trajectory,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam,
                                      std::vector<types::Keyframe> frames) {
    auto after = keyframes.begin();
    for (types::Keyframe& frame : frames) {
        while (after != keyframes.end() && after->timestamp_ns <= frame.timestamp_ns) ++after;
        if (after != keyframes.begin()) frame.segment = std::prev(after)->segment;
        frame.T_world_cam =
            trajectory[frame_at(trajectory, frame.timestamp_ns)].T_world_imu * T_imu_cam;
    }
    return frames;
}

}  // namespace divemesh::optimisation
