#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace divemesh::types {

// How uncertain a pose is relative to the first one, in the axes of the body at the first pose.
struct PoseCovariance {
    std::int64_t timestamp_ns = 0;
    Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d rotation_rad2 = Eigen::Matrix3d::Zero();
};
using CovarianceTrack = std::vector<PoseCovariance>;  // stamps strictly rising

}  // namespace divemesh::types
