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

struct FoundLoops {
    std::vector<Loop> loops;
    types::LoopStatistics statistics;
};

// Places that the dive came to again: keyframes that look alike, where the track may have been at
// the same place by then; that agree in geometry; and that agree with each other. From a place that
// was recognised the loops grow: the keyframes before and after it are measured by where they must
// be.
FoundLoops find_loops(const types::Track& track,
                      const DriftModel& drift,
                      const keyframes::KeyframeStore& store,
                      std::uint64_t seed,
                      const base::ProgressCallback& progress);

}  // namespace divemesh::loops
