#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// A plane, by n . p = 1 for its points, m.
using Plane = Eigen::Vector3d;

// Through `p_cam`, facing the camera.
inline Plane fronto_parallel_plane(const Eigen::Vector3d& p_cam) {
    return {0.0, 0.0, 1.0 / p_cam.z()};
}

// d pixel(from) / d pixel(to) at a point of a plane, both in the camera `from`. Nothing when it is
// too near to the camera `to`, or stretched more than 2.5 times either way.
std::optional<Eigen::Matrix2d> plane_warp(const types::RectifiedRig& rig,
                                          const Eigen::Vector3d& p_from,
                                          const Plane& plane_from,
                                          const Eigen::Isometry3d& T_to_from);

}  // namespace divemesh::features
