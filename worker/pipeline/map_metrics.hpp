#pragma once

#include <cstdint>

#include "worker/fusion/fusion_volume.hpp"

namespace divemesh::pipeline {

// The edges of voxels where surface was seen at the dive's median depth, nearest and farthest.
struct VoxelSizes {
    double median_m = 0.0;
    double finest_m = 0.0;
    double coarsest_m = 0.0;
};

// Metrics of the cloud and of what was fused, known when the cloud is written.
struct CloudMetrics {
    std::int64_t num_points = 0;  // written
    double spacing_m = 0.0;
    std::int64_t num_octree_points = 0;
    std::int64_t octree_bytes = 0;  // in memory and on disk
    fusion::FusedPixels fused;      // in the volume
};

}  // namespace divemesh::pipeline
