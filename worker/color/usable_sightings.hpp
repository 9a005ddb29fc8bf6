#pragma once

#include <array>

#include "worker/color/sighting.hpp"

namespace divemesh::color {

// Returns the sightings that a fit can use, of the points that have enough of them, renumbered:
// those with finite values and no saturated channel.
Sightings usable_sightings(const Sightings& sightings);

// Returns whether there is light, but no sighting has a colour.
bool is_grey(const Sightings& sightings);

// Returns the share of the sightings with light enough to tell of the water, of each channel.
std::array<double, 3> lit_shares(const Sightings& sightings);

// The ranges that a fit can rest on.
struct Ranges {
    double near_m = 0.0;
    double median_m = 0.0;
    double far_m = 0.0;
    double spread_m = 0.0;  // 80th percentile over the points of farthest less nearest
};
Ranges ranges_of(const Sightings& sightings);

}  // namespace divemesh::color
