#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"

namespace divemesh::loops {

// Returns, of every run of neighbouring loops that join the same two parts of the track, the one
// with the most reobservations, so that about `num_wanted` are left, evenly over the dive. The
// indices ascend.
std::vector<std::size_t> strongest_loops(const std::vector<Loop>& loops,
                                         const DriftModel& drift,
                                         std::size_t num_wanted);

}  // namespace divemesh::loops
