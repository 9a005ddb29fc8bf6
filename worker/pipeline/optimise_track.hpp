#pragma once

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig_alignment.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Optimises the whole dive: closes loops, refines the calibration, and adjusts keyframes and
// landmarks together. After each of them the track is compared with the one before. A result that
// agrees less with the measurements is not taken, and a finding says so. The track must have at
// least two keyframes. The bounds hold how uncertain the `alignment` of the cameras is.
// `with_prior` asks for OptimisedTrack::prior.
types::OptimisedTrack optimise_track(
    const types::Track& track,
    const types::Recording& recording,
    const ReconstructionOptions& options,
    const keyframes::KeyframeStore& store,
    const types::RigAlignment& alignment,
    const base::ProgressCallback& progress,
    optimisation::WithPrior with_prior = optimisation::WithPrior::No);

}  // namespace divemesh::pipeline
