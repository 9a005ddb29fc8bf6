#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace divemesh::base {

// A straight line through a point.
struct Ray {
    Eigen::Vector3d origin;
    Eigen::Vector3d direction;  // of any length but 0
};

// Returns the point with the least sum of squared distances to all rays. nullopt if their parallax,
// the mean squared sine of their angles to a common direction, is less than `min_parallax`.
std::optional<Eigen::Vector3d> nearest_to_rays(const std::vector<Ray>& rays, double min_parallax);

}  // namespace divemesh::base
