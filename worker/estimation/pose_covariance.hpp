#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/keyframe.hpp"
#include "worker/recording.hpp"

namespace divemesh::worker {

// How uncertain a pose is relative to the first one, in the axes of the body at the first pose.
struct PoseCovariance {
    std::int64_t timestamp_ns = 0;
    Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d rotation_rad2 = Eigen::Matrix3d::Zero();
};
using CovarianceTrack = std::vector<PoseCovariance>;  // stamps strictly rising

// Linearly between those of the keyframes, beyond their ends as at the end.
PoseCovariance covariance_between(const CovarianceTrack& keyframes, std::int64_t timestamp_ns);

// Of every frame: linearly between those of the keyframes, beyond their ends as at the end; and
// what the odometry that it follows them by adds. That errs by independent steps, as far as it
// misses from one keyframe to the next, median over the dive or here, whichever is more; tied to
// keyframes at both ends its error is a Brownian bridge.
CovarianceTrack covariances_at(const CovarianceTrack& covariances,
                               const Trajectory& odometry,
                               const std::vector<Keyframe>& keyframes,
                               const Eigen::Isometry3d& T_imu_cam);

}  // namespace divemesh::worker
