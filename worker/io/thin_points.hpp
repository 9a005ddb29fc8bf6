#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace divemesh::io {

// Returns the indices of at most `max_points` points, evenly over space, in rising order; all of
// them if they are not more. It halves a grid until it has more occupied cells than wanted, takes
// one point a cell, and of these every so many along the Morton order. The same points give the
// same indices.
std::vector<std::size_t> thin_points(const std::vector<Eigen::Vector3f>& points,
                                     std::size_t max_points);

}  // namespace divemesh::io
