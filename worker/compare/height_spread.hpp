#pragma once

#include <Eigen/Core>
#include <vector>

namespace divemesh::compare {

// Returns the 80th percentile of the absolute values; 0 without values.
double percentile_80(std::vector<double> values);

// Returns the 80th percentile of the distances along z from the best-fitting plane, m; 0 for fewer
// than four points, or if they lie above a line.
double height_spread_m(const std::vector<Eigen::Vector3d>& places);

}  // namespace divemesh::compare
