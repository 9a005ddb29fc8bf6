#pragma once

namespace divemesh::types {

// The pixels of an orthographic image of the world from above (along gravity). Row 0 is north
// (largest y), column 0 west (smallest x); pixel (0, 0) has its outer corner at `corner_x_m`,
// `corner_y_m`.
struct RasterGrid {
    int width_px = 1;
    int height_px = 1;
    double pixel_m = 1.0;
    double corner_x_m = 0.0;
    double corner_y_m = 0.0;
};

}  // namespace divemesh::types
