#pragma once

#include <cstdint>

#include "worker/types/mesh.hpp"
#include "worker/types/raster_grid.hpp"

namespace divemesh::mosaic {

// The limits of a mosaic's size; beyond them its pixels become coarser. TagLab and Qt read images
// of at most 32,767 pixels a side.
struct MosaicLimits {
    int max_side_px = 32'767;
    std::int64_t max_pixels = 1'000'000'000;
};

// Returns pixels of `pixel_m` that cover a mesh; within the limits, coarser ones of a whole number
// of tenths of a millimetre. A mesh without triangles has one pixel.
types::RasterGrid mosaic_grid(const types::Mesh& mesh,
                              double pixel_m,
                              const MosaicLimits& limits = {});

}  // namespace divemesh::mosaic
