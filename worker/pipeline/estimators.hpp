#pragma once

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// A way to estimate the path: its tracker, and what it leaves out.
struct Estimator {
    types::Track (*track)(types::Recording& recording,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          const base::ProgressCallback& progress);
    bool adjusts_whole_dive;  // loops, calibration and bundle adjustment may follow
    bool tries_reductions;    // where vision loses the scene, smaller images are tried
};

// Returns the one that `options` name: that of the paper, or the sliding window.
const Estimator& estimator_of(const ReconstructionOptions& options);

}  // namespace divemesh::pipeline
