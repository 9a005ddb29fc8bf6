#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace divemesh::mesh {

// A triangle seen from above: its corners in pixels (x to the right, y down, pixel centres at
// halves), with the height of each as z.
using PixelTriangle = std::array<Eigen::Vector3f, 3>;

// Calls visit(row, column, weights, height) for each pixel of an image whose centre lies in the
// triangle; `weights` (Eigen::Vector3f) are the barycentric weights of the corners.
template <typename Visit>
void for_each_pixel(const PixelTriangle& corners, int rows, int columns, const Visit& visit) {
    const auto& [a, b, c] = corners;
    const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0F) return;
    const auto first = [](float low) {
        return std::max(0, static_cast<int>(std::ceil(low - 0.5F)));
    };
    const auto last = [](float high, int count) {
        return std::min(count - 1, static_cast<int>(std::floor(high - 0.5F)));
    };
    const int last_row = last(std::max({a.y(), b.y(), c.y()}), rows);
    const int last_column = last(std::max({a.x(), b.x(), c.x()}), columns);
    const int first_column = first(std::min({a.x(), b.x(), c.x()}));
    for (int row = first(std::min({a.y(), b.y(), c.y()})); row <= last_row; ++row)
        for (int column = first_column; column <= last_column; ++column) {
            const float x = static_cast<float>(column) + 0.5F;
            const float y = static_cast<float>(row) + 0.5F;
            const float v = ((x - a.x()) * (c.y() - a.y()) - (y - a.y()) * (c.x() - a.x())) / area;
            const float w = ((b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x())) / area;
            const float u = 1.0F - v - w;
            if (u < 0.0F || v < 0.0F || w < 0.0F) continue;
            visit(row, column, Eigen::Vector3f(u, v, w), u * a.z() + v * b.z() + w * c.z());
        }
}

}  // namespace divemesh::mesh
