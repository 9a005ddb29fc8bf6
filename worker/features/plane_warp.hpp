#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// A plane n, with n . p = 1 for its points p, m.
using Plane = Eigen::Vector3d;

// Returns the plane through `p_cam` that faces the camera.
inline Plane fronto_parallel_plane(const Eigen::Vector3d& p_cam) {
    return {0.0, 0.0, 1.0 / p_cam.z()};
}

// Returns d pixel(from) / d pixel(to) at a point of a plane, both in the camera `from`. nullopt if
// the point is too close to the camera `to`, or if the warp stretches or shrinks by more than 2.5.
std::optional<Eigen::Matrix2d> plane_warp(const types::RectifiedRig& rig,
                                          const Eigen::Vector3d& p_from,
                                          const Plane& plane_from,
                                          const Eigen::Isometry3d& T_to_from);

}  // namespace divemesh::features
