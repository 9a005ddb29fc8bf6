#include "worker/reef/dilate_steps.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace divemesh::reef {
namespace {

// Dilates by one spacing: straight neighbours are one away. Every second ring includes the diagonal
// ones, so that a point grows to an octagon.
void dilate(HeightGrid& grid, bool with_corners, double sign) {
    const HeightGrid before = grid;
    const GridShape& shape = grid.shape;
    for (int row = 0; row < shape.num_rows; ++row)
        for (int column = 0; column < shape.num_columns; ++column) {
            double& height = grid.heights_m[shape.index(column, row)];
            if (!(height > kUnseen_m)) continue;
            for (int y = std::max(0, row - 1); y <= std::min(shape.num_rows - 1, row + 1); ++y)
                for (int x = std::max(0, column - 1);
                     x <= std::min(shape.num_columns - 1, column + 1);
                     ++x) {
                    const bool is_corner = x != column && y != row;
                    if (!before.is_seen(x, y) || (is_corner && !with_corners)) continue;
                    const double lower = shape.spacing_m * (is_corner ? std::numbers::sqrt2 : 1.0);
                    const double reached = sign * before.at(x, y) - lower;
                    if (x != column || y != row) height = sign * std::max(sign * height, reached);
                }
        }
}

}  // namespace

HeightGrid with_steps_dilated(const HeightGrid& grid, double outwards_m) {
    HeightGrid moved = grid;
    const auto num_rings =
        static_cast<int>(std::lround(std::abs(outwards_m) / grid.shape.spacing_m));
    for (int ring = 0; ring < num_rings; ++ring)
        dilate(moved, ring % 2 == 1, outwards_m > 0.0 ? 1.0 : -1.0);
    return moved;
}

}  // namespace divemesh::reef
