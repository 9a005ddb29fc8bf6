#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace divemesh::types {

// The covariance of a pose relative to the first pose, in the body axes of the first pose.
struct PoseCovariance {
    std::int64_t timestamp_ns = 0;
    Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d rotation_rad2 = Eigen::Matrix3d::Zero();
};
using CovarianceTrack = std::vector<PoseCovariance>;  // timestamps strictly ascending

}  // namespace divemesh::types
