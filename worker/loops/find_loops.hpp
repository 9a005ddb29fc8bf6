#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"
#include "worker/types/loop_statistics.hpp"
#include "worker/types/track.hpp"

namespace divemesh::loops {

// The accepted loops of a dive, with statistics of the search.
struct FoundLoops {
    std::vector<Loop> loops;
    types::LoopStatistics statistics;
};

// Finds places that the dive visits again: keyframes that look similar, whose poses may coincide
// given the drift, that pass geometric verification, and whose loops are consistent. Loops grow
// from a recognised place: the keyframes before and after it are searched at their expected
// position.
FoundLoops find_loops(const types::Track& track,
                      const DriftModel& drift,
                      const keyframes::KeyframeStore& store,
                      std::uint64_t seed,
                      const base::ProgressCallback& progress);

}  // namespace divemesh::loops
