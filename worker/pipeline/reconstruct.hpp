#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/fusion/fusion_volume.hpp"
#include "worker/fusion/octree_volume.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/mesh/extract_surface.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig_alignment.hpp"
#include "worker/types/track.hpp"

// The method: functions that together are the paper's eight steps. Each is a function from values
// to values, so a stage can start from what the previous one wrote to disk
// (worker/pipeline/stage_files.hpp).
namespace divemesh::pipeline {

// Steps 1 to 6: tracks all frames with the estimator of the options and writes the frames to map
// into `store`.
types::Track track(types::Recording& recording,
                   const ReconstructionOptions& options,
                   const keyframes::KeyframeStore& store,
                   const base::ProgressCallback& progress);

// Returns the optimised track: loops closed, all keyframes adjusted, calibration refined. The
// pairwise estimator's track stays as it is. If hardly any frame was tracked, or the result
// diverged, an error is among its findings. `with_prior` asks for OptimisedTrack::prior.
types::OptimisedTrack optimise(const types::Track& track,
                               const types::Recording& recording,
                               const ReconstructionOptions& options,
                               const keyframes::KeyframeStore& store,
                               const types::RigAlignment& alignment,
                               const base::ProgressCallback& progress,
                               optimisation::WithPrior with_prior = optimisation::WithPrior::No);

// The result of step 7: the volume from which the surface is extracted, and the points of the
// cloud.
struct FusedMap {
    std::unique_ptr<fusion::Volume> volume;
    std::unique_ptr<fusion::OctreeVolume> cloud;
};

// Frames to fuse; their depth is in `store`.
struct FramesToFuse {
    const types::RectifiedRig& rig;
    const std::vector<types::Keyframe>& frames;
    double median_depth_m = 0.0;
    const keyframes::KeyframeStore& store;
    double max_depth_m = 0.0;  // whatever the options say; 0: no limit
};

// Step 7: fuses the depth of the frames. Voxels and points beyond `options.fusion_memory_bytes` are
// spilled to the folder `scratch`.
FusedMap fuse(const FramesToFuse& input,
              const ReconstructionOptions& options,
              const std::filesystem::path& scratch,
              const base::ProgressCallback& progress);

// Step 8: returns the surface of the volume.
mesh::ExtractedSurface mesh(const fusion::Volume& volume,
                            const ReconstructionOptions& options,
                            const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
