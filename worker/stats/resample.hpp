#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "worker/stats/estimate.hpp"

namespace divemesh::stats {

// Computes a statistic from the indices of the drawn individuals.
using Statistic = std::function<double(const std::vector<std::size_t>& drawn)>;
// Returns a statistic with the percentile interval of a bootstrap over the individuals (Efron 1979;
// 1000 draws). Draws for which the statistic is NaN are left out. For a single individual the
// interval is its value.
Estimate bootstrap(std::size_t num_individuals, const Statistic& statistic, std::uint64_t seed);

}  // namespace divemesh::stats
