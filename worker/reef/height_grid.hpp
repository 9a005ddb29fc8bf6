#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "worker/reef/polygon.hpp"

namespace divemesh::reef {

inline constexpr double kUnseen_m = -std::numeric_limits<double>::infinity();

// Nodes in a plane, rows along x, one spacing apart.
struct GridShape {
    Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();
    double spacing_m = 0.01;
    int num_columns = 0;
    int num_rows = 0;

    std::size_t num_nodes() const { return static_cast<std::size_t>(num_columns) * num_rows; }
    double x_m(int column) const { return origin_m.x() + column * spacing_m; }
    double y_m(int row) const { return origin_m.y() + row * spacing_m; }
    std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * num_columns + column;
    }
};

// Heights over a plane at the nodes of a grid; kUnseen_m where there is no surface or outside the
// area.
struct HeightGrid {
    GridShape shape;
    std::vector<double> heights_m;

    double at(int column, int row) const { return heights_m[shape.index(column, row)]; }
    bool is_seen(int column, int row) const { return at(column, row) > kUnseen_m; }
};

// Returns a grid over the outline's bounds, from their lowest corner; it includes the far sides if
// they are a whole number of spacings away.
GridShape grid_over(const Polygon& outline, double spacing_m);

// Returns 1 for nodes inside the outline or on it, with a tolerance of 0.05 mm.
std::vector<std::uint8_t> nodes_within(const GridShape& shape, const Polygon& outline);

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Returns the highest surface over each node, as a survey sees it from above. Vertices are in the
// plane's frame, m; triangles seen edge-on have no height.
HeightGrid sample_heights(const std::vector<Eigen::Vector3d>& vertices,
                          const Triangles& triangles,
                          const GridShape& shape);

// Returns every step-th node of every step-th row: what sampling at that spacing would give.
HeightGrid every(const HeightGrid& grid, int step);

// Returns the means of the seen heights within a square of this side around each seen node.
HeightGrid blurred(const HeightGrid& grid, double side_m);

}  // namespace divemesh::reef
