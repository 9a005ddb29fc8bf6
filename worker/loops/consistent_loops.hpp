#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"

namespace divemesh::loops {

// Returns the largest set of loops that agree pairwise: the cycle over one loop, along the track
// and back over the other closes within the drift of the track (pairwise consistent measurement set
// maximisation, Mangelson et al. 2018). A single loop has no confirmation and is left out, as is a
// loop across a tracking gap with fewer than two others. The indices ascend.
std::vector<std::size_t> consistent_loops(const std::vector<Loop>& loops,
                                          const std::vector<types::Keyframe>& keyframes,
                                          const DriftModel& drift);

}  // namespace divemesh::loops
