#pragma once

#include <Eigen/Core>
#include <vector>

namespace divemesh::compare {

// The size that four fifths of the values do not exceed; 0 of none.
double percentile_80(std::vector<double> values);

// How far places range about the plane that fits them best along z, m: four fifths of them by no
// more. 0 of fewer than four, and of such as lie above a line.
double height_spread_m(const std::vector<Eigen::Vector3d>& places);

}  // namespace divemesh::compare
