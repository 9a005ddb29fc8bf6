#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/base/nearest_to_rays.hpp"
#include "worker/types/port.hpp"

namespace divemesh::camera {

// Returns the ray in the water that leaves the lens in a direction (camera axes, any length):
// its origin on the outer face of the port, in the camera's frame, and its unit direction. The ray
// is refracted at both faces by Snell's law in vector form (Glassner, "An Introduction to Ray
// Tracing", 1989). nullopt where it does not pass the port.
std::optional<base::Ray> ray_in_water(const types::Port& port, const Eigen::Vector3d& direction);

// Returns the direction, with z = 1, in which the light of a point in the water arrives at the
// lens: the inverse of ray_in_water() by Broyden's method (1965), as the path through two faces has
// no closed form of use (Agrawal, Ramalingam, Taguchi and Chari 2012: a polynomial of degree 12).
// The point is in the camera's frame, m. nullopt where no ray reaches the lens from the front.
std::optional<Eigen::Vector3d> direction_to(const types::Port& port, const Eigen::Vector3d& p_cam);

}  // namespace divemesh::camera
