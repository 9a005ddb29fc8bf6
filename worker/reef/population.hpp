#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/stats/estimate.hpp"

namespace divemesh::reef {

// Colonies of one label on the surveyed ground. They are a sample of the reef, so the intervals
// cover the count of another survey of as much ground.
struct Population {
    std::vector<double> areas_m2;     // planar, one per colony
    std::vector<double> diameters_m;  // longest diameter, one per colony
    double surveyed_m2 = 0.0;
};

// Returns a Poisson count with its exact interval (Garwood 1936).
stats::Estimate poisson_count(std::size_t num);

// Returns colonies per m2, with the interval of poisson_count().
stats::Estimate density_per_m2(const Population& population);

// Returns the share of the surveyed ground, with the variance of a compound Poisson sum: that of
// the squared areas.
stats::Estimate cover(const Population& population);

// Returns a quantile of at least one size by linear interpolation, bootstrapped over the colonies.
stats::Estimate size_quantile(const std::vector<double>& sizes, double share, std::uint64_t seed);

}  // namespace divemesh::reef
