#pragma once

#include <cstdint>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/loop_statistics.hpp"
#include "worker/base/observer.hpp"
#include "worker/types/track.hpp"

namespace divemesh::worker {

struct FoundLoops {
    std::vector<Loop> loops;
    LoopStatistics statistics;
};

// Places that the dive came to again: keyframes that look alike, where the track may have been at
// the same place by then; that agree in geometry; and that agree with each other. From a place that
// was recognised the loops grow: the keyframes before and after it are measured by where they must
// be.
FoundLoops find_loops(const Track& track,
                      const DriftModel& drift,
                      const KeyframeStore& store,
                      std::uint64_t seed,
                      const ProgressCallback& progress);

}  // namespace divemesh::worker
