#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/camera/lens_model.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::camera {

// Returns true if the lens may see beyond 85 degrees: its rays then end at kMaxFisheyeAngle_rad.
bool is_fisheye(const types::Camera& camera);
// Returns the pixel of a point in the camera frame (m, z forward); nullopt if the point is not in
// front of the camera, or no ray from it passes a flat port. The pixel may lie outside the image.
std::optional<Eigen::Vector2d> project(const types::Camera& camera, const Eigen::Vector3d& p_cam);
// Returns the ray through a pixel, with z = 1.
Eigen::Vector3d unproject(const types::Camera& camera, const Eigen::Vector2d& pixel);
// Returns true if the pixel lies in the image.
bool contains(const types::Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace divemesh::camera
