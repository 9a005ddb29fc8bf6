#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "worker/evaluation/surface_index.hpp"

namespace divemesh::bench {

// A level square with sides along x and y, whose heights are sampled from above every 2 mm.
struct Square {
    Eigen::Vector2d corner_m = Eigen::Vector2d::Zero();  // the lowest x and y
    double side_m = 0.6;
};

// Heights above z = 0, row by row along x from the corner; NaN where there is no surface.
struct SquareHeights {
    static constexpr int kPerMetre = 500;
    int num_nodes = 0;  // along a side
    std::vector<double> heights_m;

    double at(int column, int row) const { return heights_m[row * num_nodes + column]; }
    double share_known() const;
};

// Returns the heights of the first surface on the way down from z = above_m.
SquareHeights heights_of(const Square& square,
                         const evaluation::SurfaceIndex& surface,
                         double above_m);

// The metrics that docs/measuring.md defines, implemented a second time to check the product's. A
// result is nullopt if no height is known.

// Returns the area of the triangles between samples `spacing_m` apart (a multiple of 2 mm), divided
// by their area seen from above. Leaves out cells with an unknown corner, and takes the mean of
// both diagonals of a cell.
std::optional<double> true_rugosity(const SquareHeights& heights, double spacing_m);
struct HeightRange {
    double low_m = 0.0;
    double high_m = 0.0;

    double size_m() const { return high_m - low_m; }
};
// Returns the lowest and the highest known height.
std::optional<HeightRange> true_range(const SquareHeights& heights);
// Returns the volume above the plane z = plane_z_m. Unknown heights count as the mean of the known
// ones.
double true_volume_m3(const SquareHeights& heights, double plane_z_m);
// Returns the slope of the plane that fits the heights.
double true_slope_deg(const SquareHeights& heights);
// Returns the area of all sheets within the square, as far as nothing hides them from all of the
// cameras: where objects are sunk into the ground, triangles of both go on inside of the other.
double true_surface_area_m2(const Square& square,
                            const types::Mesh& mesh,
                            const evaluation::SurfaceIndex& surface,
                            const std::vector<Eigen::Vector3d>& cameras);

}  // namespace divemesh::bench
