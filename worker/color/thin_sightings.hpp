#pragma once

#include <cstddef>
#include <vector>

#include "worker/color/sighting.hpp"

namespace divemesh::color {

// Keeps `num` of a point's sightings, but at least two, spread over its ranges: the nearest, the
// farthest, and steps between them as even as there are. They stay in the order of their keyframes.
void thin_sightings(std::vector<Sighting>& sightings, std::size_t num);

}  // namespace divemesh::color
