#pragma once

#include <Eigen/Core>
#include <bitset>
#include <cstddef>
#include <ranges>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::types {

// Returns the number of cells of the left image, of 8 x 6, in which a pixel lies.
template <std::ranges::input_range Pixels>
std::size_t num_cells(const RectifiedRig& rig, const Pixels& pixels) {
    constexpr int kColumns = 8;
    constexpr int kRows = 6;
    std::bitset<kColumns * kRows> seen;
    for (const Eigen::Vector2d& pixel : pixels) {
        const int column = static_cast<int>(pixel.x() * kColumns / rig.width_px);
        const int row = static_cast<int>(pixel.y() * kRows / rig.height_px);
        if (column >= 0 && column < kColumns && row >= 0 && row < kRows)
            seen.set(static_cast<std::size_t>(row * kColumns + column));
    }
    return seen.count();
}

}  // namespace divemesh::types
