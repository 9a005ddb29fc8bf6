#pragma once

#include <Eigen/Core>
#include <bitset>
#include <cstddef>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Returns the number of cells of the left image, of 8 x 6, in which the pixel of an item lies.
template <typename Items, typename PixelOf>
std::size_t num_cells(const types::RectifiedRig& rig, const Items& items, const PixelOf& pixel_of) {
    constexpr int kColumns = 8;
    constexpr int kRows = 6;
    std::bitset<48> seen;
    for (const auto& item : items) {
        const Eigen::Vector2d pixel = pixel_of(item);
        const int column = static_cast<int>(pixel.x() * kColumns / rig.width_px);
        const int row = static_cast<int>(pixel.y() * kRows / rig.height_px);
        if (column < 0 || column >= kColumns || row < 0 || row >= kRows) continue;
        const int cell = row * kColumns + column;
        seen.set(static_cast<std::size_t>(cell));
    }
    return seen.count();
}

}  // namespace divemesh::odometry
