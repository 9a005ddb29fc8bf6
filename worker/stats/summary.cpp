#include "worker/stats/summary.hpp"

#include <cmath>
#include <numeric>

namespace divemesh::stats {

double mean(const std::vector<double>& values) {
    if (values.empty()) return 0.0;
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double root_mean_square(const std::vector<double>& values) {
    if (values.empty()) return 0.0;
    const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
    return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace divemesh::stats
