#include "worker/evaluation/trajectory_pairs.hpp"

#include <algorithm>

#include "worker/base/seconds.hpp"

namespace divemesh::evaluation {
namespace {

Eigen::Isometry3d interpolate(const types::StampedPose& a,
                              const types::StampedPose& b,
                              std::int64_t time_ns) {
    const double share = static_cast<double>(time_ns - a.timestamp_ns) /
                         static_cast<double>(b.timestamp_ns - a.timestamp_ns);
    const Eigen::Quaterniond q_a(a.T_world_imu.linear());
    const Eigen::Quaterniond q_b(b.T_world_imu.linear());
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = q_a.slerp(share, q_b).toRotationMatrix();
    pose.translation() =
        (1.0 - share) * a.T_world_imu.translation() + share * b.T_world_imu.translation();
    return pose;
}

}  // namespace

std::optional<Eigen::Isometry3d> pose_at(const types::Trajectory& trajectory,
                                         std::int64_t timestamp_ns,
                                         const TrajectoryErrorOptions& options) {
    if (trajectory.empty()) return std::nullopt;
    const auto after = std::lower_bound(
        trajectory.begin(),
        trajectory.end(),
        timestamp_ns,
        [](const types::StampedPose& pose, std::int64_t time) { return pose.timestamp_ns < time; });
    if (after != trajectory.end() && after->timestamp_ns == timestamp_ns) return after->T_world_imu;
    if (after == trajectory.begin() || after == trajectory.end()) {
        const types::StampedPose& end = after == trajectory.end() ? trajectory.back() : *after;
        const double beyond = std::abs(base::to_s(end.timestamp_ns - timestamp_ns));
        if (beyond > options.max_extrapolation_s) return std::nullopt;
        return end.T_world_imu;
    }
    const types::StampedPose& before = *std::prev(after);
    if (base::to_s(after->timestamp_ns - before.timestamp_ns) > options.max_gap_s)
        return std::nullopt;
    return interpolate(before, *after, timestamp_ns);
}

std::vector<PosePair> pair_poses(const types::Trajectory& estimate,
                                 const types::Trajectory& reference,
                                 const TrajectoryErrorOptions& options) {
    const Eigen::Isometry3d T_estimatebody_referencebody =
        options.T_referencebody_estimatebody.inverse();
    std::vector<PosePair> pairs;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        const auto& [time_ns, T_world_estimatebody] = estimate[i];
        std::optional<Eigen::Isometry3d> truth;
        if (!options.pair_by_index)
            truth = pose_at(reference, time_ns, options);
        else if (i < reference.size())
            truth = reference[i].T_world_imu;
        if (truth)
            pairs.push_back({time_ns, *truth, T_world_estimatebody * T_estimatebody_referencebody});
    }
    return pairs;
}

}  // namespace divemesh::evaluation
