#include "worker/fusion/depth_ranges.hpp"

#include <cmath>

namespace divemesh::fusion {
namespace {

// Limit in shares of a pixel's depth, as surface seen at a grazing angle has no end.
constexpr float kMaxDepthRatio = 3.0F;

// Returns the range along the optical axis in which a pixel changes samples. Samples lie anywhere
// in the pixel, so the surface counts as near and as far as at the pixel's corners. The noise, and
// so the truncation, grows with the square of the depth: behind the surface it ends where z - depth
// = noise z^2, if there is a solution.
DepthRange range_of(const TsdfView& view, const SurfacePixel& pixel) {
    const float max_depth = kMaxDepthRatio * pixel.depth_m;
    const float across =
        pixel.offset_m / pixel.depth_m;  // along the plane's normal, per metre of z
    const float to_corner =
        0.5F * (std::abs(pixel.normal[0]) + std::abs(pixel.normal[1])) / view.focal_px;
    if (across <= to_corner) return {0.0F, max_depth};
    const float far_depth = pixel.offset_m / (across - to_corner);
    if (!makes_surface(view, pixel)) return {pixel.depth_m, std::min(max_depth, far_depth)};
    const float near_depth = pixel.offset_m / (across + to_corner);
    const float min_truncation = kTruncation_voxels * view.voxel_m;
    const float noise = kTruncation_sigmas * (pixel.sigma_disparity_px *
                                              view.depth_sigma_scale);  // 1/m, along the normal
    const float nearest =
        std::max(min_truncation, noise * near_depth * near_depth) / (across + to_corner);
    const float root = 1.0F - 4.0F * noise * far_depth / (across - to_corner);
    const float noise_ends = root <= 0.0F ? max_depth : 2.0F * far_depth / (1.0F + std::sqrt(root));
    const float min_ends = far_depth + min_truncation / (across - to_corner);
    return {near_depth - nearest, std::min(max_depth, std::max(min_ends, noise_ends))};
}

}  // namespace

DepthRanges::DepthRanges(const TsdfView& view)
    : farthest_m_(static_cast<std::size_t>(view.width_px) * view.height_px, 0.0F) {
    for (int i = 0; i < kNumLevels; ++i) {
        Level& level = levels_[i];
        level.num_columns = (view.width_px + tile_px(i) - 1) / tile_px(i);
        level.num_rows = (view.height_px + tile_px(i) - 1) / tile_px(i);
        level.of_tile.resize(static_cast<std::size_t>(level.num_columns) * level.num_rows);
        level.around.resize(level.of_tile.size());
    }
    read_pixels(view);
    for (int i = 1; i < kNumLevels; ++i)
        for (int row = 0; row < levels_[i - 1].num_rows; ++row)
            for (int column = 0; column < levels_[i - 1].num_columns; ++column)
                levels_[i].of_tile[index(levels_[i], column / 2, row / 2)].extend(
                    levels_[i - 1].of_tile[index(levels_[i - 1], column, row)]);
    for (int i = 0; i < kNumLevels; ++i) {
        Level& level = levels_[i];
        for (int row = 0; row < level.num_rows; ++row)
            for (int column = 0; column < level.num_columns; ++column)
                level.around[index(level, column, row)] =
                    over(i,
                         std::max(0, column - 1),
                         std::min(level.num_columns - 1, column + 1),
                         std::max(0, row - 1),
                         std::min(level.num_rows - 1, row + 1));
    }
}

void DepthRanges::read_pixels(const TsdfView& view) {
    Level& finest = levels_[0];
    for (int v = 0; v < view.height_px; ++v)
        for (int u = 0; u < view.width_px; ++u) {
            const int i = v * view.width_px + u;
            if (view.pixels[i].weight <= 0.0F) continue;
            const DepthRange range = range_of(view, view.pixels[i]);
            farthest_m_[i] = range.farthest_m;
            finest.of_tile[index(finest, u / tile_px(0), v / tile_px(0))].extend(range);
        }
}

DepthRange DepthRanges::over(
    int level, int first_column, int last_column, int first_row, int last_row) const {
    DepthRange range;
    for (int row = first_row; row <= last_row; ++row)
        for (int column = first_column; column <= last_column; ++column)
            range.extend(levels_[level].of_tile[index(levels_[level], column, row)]);
    return range;
}

}  // namespace divemesh::fusion
