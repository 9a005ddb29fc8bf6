#pragma once

#include <filesystem>

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Returns the smallest reduction that makes images no wider than a limit; 0: no limit.
int reduction_to_width(int width_px, int max_width_px);

// Returns the reduction of the images at which vision follows far more of the dive than in `track`,
// a multiple of the track's: soft images, of turbid water or out of focus, have nothing to track in
// their finest pixels. The track's own if none does, or most of the dive was tracked. The attempts
// keep their files in `scratch`, which is removed. The recording is left as for `track`, at its
// first frame.
int better_reduction(const types::Track& track,
                     const ReconstructionOptions& options,
                     const std::filesystem::path& scratch,
                     AlignedRecording& recording,
                     const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
