#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// A feature with a 3D point at both times.
struct PointPair {
    std::int64_t id = 0;
    Eigen::Vector3d previous_px = Eigen::Vector3d::Zero();  // u, v, disparity
    Eigen::Vector3d current_px = Eigen::Vector3d::Zero();
    Eigen::Vector3d previous_sigma_px = types::kFeatureSigma_px;
    Eigen::Vector3d current_sigma_px = types::kFeatureSigma_px;
    Eigen::Vector3d p_previous = Eigen::Vector3d::Zero();  // m, in the camera at t-1
    Eigen::Vector3d p_current = Eigen::Vector3d::Zero();   // m, in the camera at t
};
// ids ascending
using PointPairs = std::vector<PointPair>;

// Step 3: returns the features whose depth is known at t-1 and at t.
PointPairs with_depth_at_both_times(const types::RectifiedRig& rig,
                                    const types::Features& previous,
                                    const types::Features& current);

}  // namespace divemesh::odometry
