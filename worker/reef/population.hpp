#pragma once

#include <cstdint>
#include <vector>

#include "worker/reef/estimate.hpp"

namespace divemesh::worker {

// Colonies of one label on the surveyed ground: a sample of the reef, so that the intervals say
// what another survey of as much ground might count.
struct Population {
    std::vector<double> areas_m2;     // planar, one a colony
    std::vector<double> diameters_m;  // longest, likewise
    double surveyed_m2 = 0.0;
};

// Colonies per m2, with the exact interval of a Poisson count (Garwood 1936, by the chi-square
// quantiles of Wilson and Hilferty 1931).
Estimate density_per_m2(const Population& population);

// Share of the surveyed ground, with the variance of a compound Poisson sum: that of the squared
// areas.
Estimate cover(const Population& population);

// A quantile of the sizes by linear interpolation, with the percentiles of a bootstrap over the
// colonies (Efron 1979; 1000 draws, fixed seed). Of one colony: its size, no interval to speak of.
Estimate size_quantile(std::vector<double> sizes, double share, std::uint64_t seed);

}  // namespace divemesh::worker
