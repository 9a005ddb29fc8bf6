#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"

namespace divemesh::loops {

// Of every run of neighbouring loops that join the same two pieces of the track the one that sees
// most again, so that about `most` are left, evenly over the dive. Returns indices, rising.
std::vector<std::size_t> strongest_loops(const std::vector<Loop>& loops,
                                         const DriftModel& drift,
                                         std::size_t most);

}  // namespace divemesh::loops
