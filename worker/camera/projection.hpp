#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/base/nearest_to_rays.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::camera {

// Returns true if the lens may see beyond 85 degrees: its rays then end at kMaxFisheyeAngle_rad.
bool is_fisheye(const types::Camera& camera);
// Returns the pixel of a point in the camera frame (m, z forward); nullopt if the point is not in
// front of the camera, or no ray from it passes a flat port. The pixel may lie outside the image.
std::optional<Eigen::Vector2d> project(const types::Camera& camera, const Eigen::Vector3d& p_cam);
// Returns the ray on which the camera sees what a pixel shows, in its frame: a direction with
// z = 1, and an origin that is not the camera's only if a port refracts the ray.
base::Ray sight_ray(const types::Camera& camera, const Eigen::Vector2d& pixel);
// Returns the direction with z = 1 from the camera's origin to what a pixel shows; behind a port to
// what it shows at the port's reference depth.
Eigen::Vector3d unproject(const types::Camera& camera, const Eigen::Vector2d& pixel);
// Returns by how much the port enlarges what the camera shows on its axis: the focal length there
// over that of the lens, about 1.34 behind a flat port in water; 1 without a port.
double axial_magnification(const types::Camera& camera);
// Returns true if the pixel lies in the image.
bool contains(const types::Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace divemesh::camera
