#include "worker/volume/depth_ranges.hpp"

namespace divemesh::worker {
namespace {

// How far before and behind its surface a pixel changes samples, along its ray. The noise, and so
// the truncation, is that of the far end.
DepthRange range_of(const TsdfView& view, const SurfacePixel& pixel) {
    if (!makes_surface(view, pixel)) return {pixel.depth_m, pixel.depth_m};
    const float along_ray = pixel.depth_m / pixel.offset_m;  // per metre across the plane
    const auto band = [&](float z) {
        const float sigma = z * z * (pixel.sigma_disparity_px * view.depth_sigma_scale);
        return along_ray * std::max(kTruncation_voxels * view.voxel_m, kTruncation_sigmas * sigma);
    };
    const float behind = pixel.depth_m + band(pixel.depth_m);
    return {pixel.depth_m - band(pixel.depth_m), pixel.depth_m + band(behind)};
}

}  // namespace

DepthRanges::DepthRanges(const TsdfView& view) {
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
            const SurfacePixel& pixel = view.pixels[v * view.width_px + u];
            if (pixel.weight > 0.0F)
                finest.of_tile[index(finest, u / tile_px(0), v / tile_px(0))].extend(
                    range_of(view, pixel));
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

}  // namespace divemesh::worker
