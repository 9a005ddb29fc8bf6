#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "worker/stats/estimate.hpp"

namespace divemesh::stats {

// A statistic over individuals with the percentiles of a bootstrap over them (Efron 1979; 1000
// draws, fixed seed). It is given the indices of those drawn; a draw for which it answers NaN is
// left out. Of one individual: its value, no interval to speak of.
using Statistic = std::function<double(const std::vector<std::size_t>& drawn)>;
Estimate bootstrap(std::size_t num_individuals, const Statistic& statistic, std::uint64_t seed);

}  // namespace divemesh::stats
