#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

#include "worker/types/mesh.hpp"

namespace divemesh::mosaic {

// An orthographic image of the mesh from above (along gravity). Row 0 is north (largest y), column
// 0 west (smallest x); pixel (0, 0) has its outer corner at `corner_x_m`, `corner_y_m`.
struct Mosaic {
    cv::Mat color;     // CV_8UC4 BGRA; alpha 0 where there is no surface
    cv::Mat height_m;  // CV_32F, world z of the highest surface; NaN where there is none
    double pixel_m = 0.0;
    double corner_x_m = 0.0;
    double corner_y_m = 0.0;
};

// The resolution of a mosaic and limits of its size.
struct MosaicOptions {
    double pixel_m = 0.0;  // 0: half the mean edge of the mesh
    int max_side_px = 8192;
    std::int64_t max_pixels = 48'000'000;  // above this the pixels become coarser
};

// Renders the mosaic in the colours of the vertices; the highest surface is visible. An empty mesh
// gives one transparent pixel.
Mosaic render_mosaic(const types::Mesh& mesh, const MosaicOptions& options = {});

// Writes mosaic.png, mosaic_height.png (16 bit; 0: no surface), mosaic.json with the scales of
// both, and a world file for each image (.pgw, the world in m) to `folder`.
void write_mosaic(const std::filesystem::path& folder, const Mosaic& mosaic);

// Returns the mosaic scaled down to `max_side_px` on white, as PNG, for the report.
std::string thumbnail_png(const Mosaic& mosaic, int max_side_px = 480);

}  // namespace divemesh::mosaic
