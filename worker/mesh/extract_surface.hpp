#pragma once

#include <string>

#include "worker/base/observer.hpp"
#include "worker/fusion/fusion_volume.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

struct ExtractedSurface {
    types::Mesh mesh;
    double small_components_m2 = 0.0;  // removed
};

// Step 8: returns the surface in the volume as one welded, outward oriented mesh, by constrained
// elastic surface nets (Gibson 1998; the paper) or marching cubes, by `mesher`. Components
// of less than 100 voxel faces are removed: they are noise, snow or fish.
ExtractedSurface extract_surface(const fusion::Volume& volume,
                                 const std::string& mesher,
                                 int num_threads,
                                 const base::ProgressCallback& progress = base::ignore_progress);

}  // namespace divemesh::mesh
