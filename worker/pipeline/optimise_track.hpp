#pragma once

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Looks at the whole dive at once: closes loops, refines the calibration and adjusts keyframes and
// landmarks together. After each of them the track is compared with how it was before; what agrees
// less with what was measured is not taken, and a finding says so. The track needs two keyframes.
types::OptimisedTrack optimise_track(const types::Track& track,
                                     const types::Recording& recording,
                                     const ReconstructionOptions& options,
                                     const keyframes::KeyframeStore& store,
                                     const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
