#include "worker/mosaic/mosaic_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace divemesh::mosaic {
namespace {

constexpr double kStep_m = 1e-4;  // of pixel sizes

Eigen::AlignedBox2d bounds_of(const types::Mesh& mesh) {
    Eigen::AlignedBox2d bounds;
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle)
            bounds.extend(mesh.vertices[vertex].head<2>().cast<double>());
    return bounds;
}

// Returns the number of pixels that cover a length and its end.
double num_pixels(double length_m, double pixel_m) { return 1.0 + std::floor(length_m / pixel_m); }

bool fits(const Eigen::Vector2d& size_m, double pixel_m, const MosaicLimits& limits) {
    const double width_px = num_pixels(size_m.x(), pixel_m);
    const double height_px = num_pixels(size_m.y(), pixel_m);
    return std::max(width_px, height_px) <= limits.max_side_px &&
           width_px * height_px <= static_cast<double>(limits.max_pixels);
}

double coarse_enough_m(const Eigen::Vector2d& size_m, double pixel_m, const MosaicLimits& limits) {
    if (fits(size_m, pixel_m, limits)) return pixel_m;
    const double needed_m =
        std::max({pixel_m,
                  size_m.maxCoeff() / limits.max_side_px,
                  std::sqrt(size_m.x() * size_m.y() / static_cast<double>(limits.max_pixels))});
    double coarse_m = std::ceil(needed_m / kStep_m) * kStep_m;
    while (!fits(size_m, coarse_m, limits)) coarse_m += kStep_m;
    return coarse_m;
}

}  // namespace

types::RasterGrid mosaic_grid(const types::Mesh& mesh, double pixel_m, const MosaicLimits& limits) {
    types::RasterGrid grid;
    if (mesh.triangles.empty()) return grid;
    const Eigen::AlignedBox2d bounds = bounds_of(mesh);
    grid.pixel_m = coarse_enough_m(bounds.sizes(), pixel_m, limits);
    grid.width_px = static_cast<int>(num_pixels(bounds.sizes().x(), grid.pixel_m));
    grid.height_px = static_cast<int>(num_pixels(bounds.sizes().y(), grid.pixel_m));
    grid.corner_x_m = bounds.min().x();
    grid.corner_y_m = bounds.max().y();
    return grid;
}

}  // namespace divemesh::mosaic
