#pragma once

#include <cstdint>
#include <vector>

#include "worker/mesh/simplify_mesh.hpp"

namespace divemesh::pipeline {

// Metrics of the surface as mesh.glb shows it.
struct TextureMetrics {
    std::int64_t num_triangles = 0;
    mesh::SimplificationError simplification;  // against mesh.ply
    std::int64_t num_atlases = 0;
    double textured_share = 0.0;    // of the area; the rest has the colours of the vertices
    double texels_per_pixel = 1.0;  // of the photographs, along a row; below 1: limited by memory
    std::vector<int> lost_frames;   // frame indices of keyframes whose images could not be read
    double mosaic_pixel_m = 0.0;    // of mosaic.tif and heights.tif; 0: there are none
};

}  // namespace divemesh::pipeline
