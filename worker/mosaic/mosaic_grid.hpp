#pragma once

#include <cstdint>

#include "worker/types/mesh.hpp"

namespace divemesh::mosaic {

// The pixels of an orthographic image of the world from above (along gravity). Row 0 is north
// (largest y), column 0 west (smallest x); pixel (0, 0) has its outer corner at `corner_x_m`,
// `corner_y_m`.
struct MosaicGrid {
    int width_px = 1;
    int height_px = 1;
    double pixel_m = 1.0;
    double corner_x_m = 0.0;
    double corner_y_m = 0.0;
};

// The limits of a mosaic's size; beyond them its pixels become coarser. TagLab and Qt read images
// of at most 32,767 pixels a side.
struct MosaicLimits {
    int max_side_px = 32'767;
    std::int64_t max_pixels = 1'000'000'000;
};

// Returns pixels of `pixel_m` that cover a mesh; within the limits, coarser ones of a whole number
// of tenths of a millimetre. A mesh without triangles has one pixel.
MosaicGrid mosaic_grid(const types::Mesh& mesh, double pixel_m, const MosaicLimits& limits = {});

}  // namespace divemesh::mosaic
