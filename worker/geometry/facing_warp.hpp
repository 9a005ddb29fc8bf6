#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/geometry/rectified_rig.hpp"

namespace divemesh::worker {

// d pixel(from) / d pixel(to) at a point `p_from`, its surface taken to face the camera `from`.
// Nothing when it is too near to the camera, or stretched more than 2.5 times either way.
std::optional<Eigen::Matrix2d> facing_warp(const RectifiedRig& rig,
                                           const Eigen::Vector3d& p_from,
                                           const Eigen::Isometry3d& T_to_from);

}  // namespace divemesh::worker
