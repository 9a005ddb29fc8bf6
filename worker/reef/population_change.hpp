#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/stats/estimate.hpp"

namespace divemesh::reef {

// One colony at two times: gone, new, or there at both. What its size is measured by is the
// caller's (m2, m).
struct Individual {
    std::optional<double> before;
    std::optional<double> after;
};

// Intervals say what another piece of the same reef, as large, might show: the same ground is
// looked at twice, so that what stayed as it was cancels and only what became of each colony
// varies.

// New less gone: the difference of two Poisson counts, its limits from theirs (MOVER; Zou and
// Donner 2008).
stats::Estimate count_change(const std::vector<Individual>& individuals);

// Sum of the sizes after less that before, with the variance of a compound Poisson sum: that of the
// squared differences.
stats::Estimate sum_change(const std::vector<Individual>& individuals);

// Median of the sizes after less that before, bootstrapped over the individuals. Nothing when one
// of both times has none.
std::optional<stats::Estimate> median_change(const std::vector<Individual>& individuals,
                                             std::uint64_t seed);

}  // namespace divemesh::reef
