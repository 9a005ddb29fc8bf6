#pragma once

#include <vector>

namespace divemesh::stats {

// Both return 0 for an empty vector.
double mean(const std::vector<double>& values);
double root_mean_square(const std::vector<double>& values);

}  // namespace divemesh::stats
