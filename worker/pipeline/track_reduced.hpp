#pragma once

#include <filesystem>

#include "schemas/finding.hpp"
#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Returns the reduction of the images at which vision follows far more of the dive than in `track`,
// which was tracked at full size: soft images, of turbid water or out of focus, have nothing to
// track in their finest pixels. 1 if none does, or most of the dive was tracked. The attempts keep
// their files in `scratch`, which is removed. The recording is left at full size and at its first
// frame.
int better_reduction(const types::Track& track,
                     const ReconstructionOptions& options,
                     const std::filesystem::path& scratch,
                     AlignedRecording& recording,
                     const base::ProgressCallback& progress);

// Returns what the user is told about images that were reduced.
Finding reduced_finding(int reduction);

}  // namespace divemesh::pipeline
