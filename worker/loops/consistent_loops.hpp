#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"

namespace divemesh::loops {

// The largest set of loops of which any two agree: going round over the one, along the track and
// back over the other ends where it began, as far as the track may drift (pairwise consistent
// measurement set maximisation, Mangelson et al. 2018). A loop that stands alone says nothing and
// is left out, and so is, where the scene was lost in between, one with less than two others.
// Returns indices, rising.
std::vector<std::size_t> consistent_loops(const std::vector<Loop>& loops,
                                          const std::vector<types::Keyframe>& keyframes,
                                          const DriftModel& drift);

}  // namespace divemesh::loops
