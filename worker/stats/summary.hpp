#pragma once

#include <vector>

namespace divemesh::stats {

// Of nothing: 0.
double mean(const std::vector<double>& values);
double root_mean_square(const std::vector<double>& values);

}  // namespace divemesh::stats
