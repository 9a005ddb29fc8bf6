#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/recording.hpp"

namespace divemesh::worker {

// How uncertain a pose is relative to the first one, in the axes of the body at the first pose.
struct PoseCovariance {
    std::int64_t timestamp_ns = 0;
    Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d rotation_rad2 = Eigen::Matrix3d::Zero();
};
using CovarianceTrack = std::vector<PoseCovariance>;  // stamps strictly rising

// Of every frame, linearly between those of the keyframes; beyond their ends as at the end. What a
// frame adds to its keyframes is small against what they have gathered, and left out.
CovarianceTrack covariances_at(const CovarianceTrack& keyframes, const Trajectory& frames);

}  // namespace divemesh::worker
