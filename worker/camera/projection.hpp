#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/types/camera.hpp"

namespace divemesh::camera {

// Returns the pixel of a point in the camera frame (m, z forward); nullopt if the point is not in
// front of the camera. The pixel may lie outside the image.
std::optional<Eigen::Vector2d> project(const types::Camera& camera, const Eigen::Vector3d& p_cam);
// Returns the ray through a pixel, with z = 1.
Eigen::Vector3d unproject(const types::Camera& camera, const Eigen::Vector2d& pixel);
// Returns true if the pixel lies in the image.
bool contains(const types::Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace divemesh::camera
