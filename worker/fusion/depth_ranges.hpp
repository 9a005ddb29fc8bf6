#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "worker/base/instructions.hpp"
#include "worker/fusion/tsdf_view.hpp"

namespace divemesh::fusion {

// The range of depths along the optical axis in which some pixels may make surface; behind
// `farthest_m` they change no sample. Empty for no pixels.
struct DepthRange {
    float nearest_m = std::numeric_limits<float>::infinity();
    float farthest_m = 0.0F;

    void extend(const DepthRange& other) {
        nearest_m = std::min(nearest_m, other.nearest_m);
        farthest_m = std::max(farthest_m, other.farthest_m);
    }
};

// The depth ranges of a view, by square tiles of 4, 8 and 16 pixels. With them, blocks that a view
// cannot change are skipped without reading its pixels.
class DepthRanges {
public:
    static constexpr int kNumLevels = 3;
    static constexpr int tile_px(int level) { return 4 << level; }

    explicit DepthRanges(const TsdfView& view,
                         base::Instructions instructions = base::best_instructions());

    // Returns the range over some tiles of a level, ends included.
    DepthRange over(
        int level, int first_column, int last_column, int first_row, int last_row) const;
    // Returns the range over a tile and its eight neighbours, which hold every pixel no farther
    // than a tile's width from any of its pixels.
    const DepthRange& around(int level, int column, int row) const {
        return levels_[level].around[index(levels_[level], column, row)];
    }
    // Returns for each pixel, row by row, the depth behind which it changes no sample; 0 if its
    // depth is unknown.
    const float* farthest_m() const { return farthest_m_.data(); }
    int num_columns(int level) const { return levels_[level].num_columns; }
    int num_rows(int level) const { return levels_[level].num_rows; }

private:
    struct Level {
        int num_columns = 0;
        int num_rows = 0;
        std::vector<DepthRange> of_tile;
        std::vector<DepthRange> around;
    };
    static std::size_t index(const Level& level, int column, int row) {
        return static_cast<std::size_t>(row) * level.num_columns + column;
    }
    void read_pixels(const TsdfView& view, base::Instructions instructions);

    std::array<Level, kNumLevels> levels_;
    std::vector<float> farthest_m_;
};

}  // namespace divemesh::fusion
