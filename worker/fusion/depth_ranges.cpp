#include "worker/fusion/depth_ranges.hpp"

#include "worker/base/lanes.hpp"

namespace divemesh::fusion {
namespace {

// Limit in shares of a pixel's depth, as surface seen at a grazing angle has no end.
constexpr float kMaxDepthRatio = 3.0F;

// The depth ranges of eight pixels.
struct RangesOfPixels {
    base::Floats nearest_m;
    base::Floats farthest_m;
};

// Returns the ranges along the optical axis in which eight pixels change samples. Samples lie
// anywhere in a pixel, so the surface counts as near and as far as at the pixel's corners. The
// noise, and so the truncation, grows with the square of the depth: behind the surface it ends
// where z - depth = noise z^2, if there is a solution.
DIVEMESH_INLINE_BODY RangesOfPixels ranges_of(const TsdfView& view, const SurfacePixel* pixels) {
    base::Floats fields[base::kLanes];
    for (int lane = 0; lane < base::kLanes; ++lane) fields[lane] = base::load(pixels[lane].normal);
    base::transpose(fields);
    const base::Floats offset = fields[3];
    const base::Floats sigma_scale = fields[4] * view.depth_sigma_scale;
    const base::Floats depth = fields[5];
    const base::Masks is_known = fields[6] > 0.0F;

    const base::Floats max_depth = kMaxDepthRatio * depth;
    const base::Floats across = offset / depth;  // along the plane's normal, per metre of z
    const base::Floats to_corner =
        0.5F * (base::abs(fields[0]) + base::abs(fields[1])) / view.focal_px;
    const base::Floats far_across = across - to_corner;
    const base::Floats near_across = across + to_corner;
    const base::Masks is_grazing = far_across <= 0.0F;
    const base::Floats far_depth = offset / far_across;
    const base::Floats near_depth = offset / near_across;
    const float min_truncation = kTruncation_voxels * view.voxel_m;
    const base::Floats noise = kTruncation_sigmas * sigma_scale;  // 1/m, along the normal
    const base::Floats nearest =
        base::max(base::broadcast(min_truncation), noise * near_depth * near_depth) / near_across;
    const base::Floats root = 1.0F - 4.0F * noise * far_depth / far_across;
    const base::Floats noise_ends =
        root <= 0.0F
            ? max_depth
            : 2.0F * far_depth / (1.0F + base::square_root(base::max(root, base::Floats{})));
    const base::Floats min_ends = far_depth + min_truncation / far_across;
    // A pixel that makes no surface only carves the space in front of it.
    const base::Masks makes_surface =
        (depth <= view.max_depth_m) & (depth * depth * sigma_scale <= view.max_sigma_m);
    const base::Floats near_end = makes_surface ? near_depth - nearest : depth;
    const base::Floats far_end = makes_surface ? base::max(min_ends, noise_ends) : far_depth;
    const base::Floats infinity = base::broadcast(DepthRange{}.nearest_m);
    return {is_known ? (is_grazing ? base::Floats{} : near_end) : infinity,
            base::select(is_known, is_grazing ? max_depth : base::min(max_depth, far_end))};
}

// Reads a row of pixels: the farthest of each, and for each column the range over the rows so far.
DIVEMESH_INLINE_BODY void read_row(const TsdfView& view,
                                   const SurfacePixel* row,
                                   float* farthest_m,
                                   float* nearest_of_column_m,
                                   float* farthest_of_column_m) {
    for (int start = 0; start < view.width_px; start += base::kLanes) {
        // The last eight pixels overlap the previous ones.
        const int u = std::min(start, view.width_px - base::kLanes);
        const RangesOfPixels ranges = ranges_of(view, row + u);
        base::store(farthest_m + u, ranges.farthest_m);
        base::store(nearest_of_column_m + u,
                    base::min(base::load(nearest_of_column_m + u), ranges.nearest_m));
        base::store(farthest_of_column_m + u,
                    base::max(base::load(farthest_of_column_m + u), ranges.farthest_m));
    }
}

}  // namespace

DepthRanges::DepthRanges(const TsdfView& view, base::Instructions instructions)
    : farthest_m_(static_cast<std::size_t>(view.width_px) * view.height_px, 0.0F) {
    for (int i = 0; i < kNumLevels; ++i) {
        Level& level = levels_[i];
        level.num_columns = (view.width_px + tile_px(i) - 1) / tile_px(i);
        level.num_rows = (view.height_px + tile_px(i) - 1) / tile_px(i);
        level.of_tile.resize(static_cast<std::size_t>(level.num_columns) * level.num_rows);
        level.around.resize(level.of_tile.size());
    }
    read_pixels(view, instructions);
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

void DepthRanges::read_pixels(const TsdfView& view, base::Instructions instructions) {
    if (view.width_px < base::kLanes) return;  // no such image has surface (DepthView)
    const auto read = base::compiled_for<read_row>(instructions);
    const auto width = static_cast<std::size_t>(view.width_px);
    Level& finest = levels_[0];
    for (int row = 0; row < finest.num_rows; ++row) {
        std::vector<float> nearest_m(width, DepthRange{}.nearest_m);
        std::vector<float> farthest_m(width, 0.0F);
        const int end = std::min(view.height_px, (row + 1) * tile_px(0));
        for (int v = row * tile_px(0); v < end; ++v)
            read(view,
                 view.pixels + v * width,
                 farthest_m_.data() + v * width,
                 nearest_m.data(),
                 farthest_m.data());
        for (std::size_t u = 0; u < width; ++u)
            finest.of_tile[index(finest, static_cast<int>(u) / tile_px(0), row)].extend(
                {nearest_m[u], farthest_m[u]});
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
