#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/types/camera.hpp"

namespace divemesh::camera {

// Point in the camera frame (m, z forward) to pixel; nothing when it is not in front of it. The
// pixel may lie outside the image.
std::optional<Eigen::Vector2d> project(const types::Camera& camera, const Eigen::Vector3d& p_cam);
// Pixel to the ray through it, z = 1.
Eigen::Vector3d unproject(const types::Camera& camera, const Eigen::Vector2d& pixel);
bool contains(const types::Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace divemesh::camera
