#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/base/observer.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/fusion/fusion_volume.hpp"
#include "worker/types/track.hpp"
#include "worker/types/mesh.hpp"
#include "worker/fusion/octree_volume.hpp"

// The method: four stages that together are the paper's eight steps. Each takes plain values and
// gives plain values, so a stage can start from what the one before wrote to disk
// (worker/pipeline/stage_files.hpp).
namespace divemesh::worker {

Track track(Recording& recording,
            const ReconstructionOptions& options,
            const KeyframeStore& store,
            const ProgressCallback& progress);

OptimisedTrack optimise(const Track& track,
                        const Recording& recording,
                        const ReconstructionOptions& options,
                        const KeyframeStore& store,
                        const ProgressCallback& progress);

// What step 7 makes: where the surface is looked for, and the points that were seen.
struct FusedMap {
    std::unique_ptr<Volume> volume;
    std::unique_ptr<OctreeVolume> cloud;
};

// Voxels and points beyond `options.fusion_memory_bytes` go to the folder `scratch`.
FusedMap fuse(const RectifiedRig& rig,
              const std::vector<Keyframe>& frames,
              double median_depth_m,
              const ReconstructionOptions& options,
              const KeyframeStore& store,
              const std::filesystem::path& scratch,
              const ProgressCallback& progress);

Mesh mesh(const Volume& volume,
          const ReconstructionOptions& options,
          const ProgressCallback& progress);

}  // namespace divemesh::worker
