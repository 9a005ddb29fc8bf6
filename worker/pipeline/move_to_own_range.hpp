#pragma once

#include "worker/types/range_table.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Moves the pixels of a track's observations, whose disparities are those of an ideal pair already,
// to where an ideal pair shows them. One by the left camera alone moves by the depth of its
// landmark as tracked.
void move_to_own_range(const types::RangeTable& ranges, types::Track& track);

}  // namespace divemesh::pipeline
