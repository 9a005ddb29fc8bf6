#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/stats/estimate.hpp"

namespace divemesh::reef {

// One colony at two times: gone, new, or present at both. The caller chooses how its size is
// measured (m2, m).
struct Individual {
    std::optional<double> before;
    std::optional<double> after;
};

// The intervals of these functions cover the changes on another part of the same reef, as large.
// The same ground is surveyed twice, so unchanged colonies cancel and only the changes of colonies
// vary.

// Returns new minus gone colonies: the difference of two Poisson counts, with an interval from
// those of both (MOVER; Zou and Donner 2008).
stats::Estimate count_change(const std::vector<Individual>& individuals);

// Returns the sum of the sizes after minus that before, with the variance of a compound Poisson
// sum: that of the squared differences.
stats::Estimate sum_change(const std::vector<Individual>& individuals);

// Returns the median of the sizes after minus that before, bootstrapped over the individuals;
// nullopt if there are no individuals at one of the times.
std::optional<stats::Estimate> median_change(const std::vector<Individual>& individuals,
                                             std::uint64_t seed);

}  // namespace divemesh::reef
