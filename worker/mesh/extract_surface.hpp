#pragma once

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/fusion/fusion_volume.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::worker {

// Step 8: the surface in the volume as one welded, outward oriented mesh: constrained elastic
// surface nets (Gibson 1998; the paper) or marching cubes, by `options.mesher`. Components of less
// than 100 voxel faces are left out: no more than noise, snow or a fish.
Mesh extract_surface(const Volume& volume,
                     const ReconstructionOptions& options,
                     const ProgressCallback& progress = ignore_progress);

}  // namespace divemesh::worker
