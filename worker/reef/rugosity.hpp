#pragma once

#include <optional>
#include <vector>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Surface over planar area of the triangles between the samples of a grid (rugosity, R; habtools
// rg; Torres-Pulliza et al. 2020, with samples in place of means over cells), the mean of both
// ways to cut a cell in two. A cell with three seen corners counts with one triangle. Nothing where
// there is none. The resolution is the grid's spacing.
struct GridArea {
    double surface_m2 = 0.0;
    double planar_m2 = 0.0;
};
GridArea grid_area(const HeightGrid& grid);
std::optional<double> rugosity(const HeightGrid& grid);

// rg of habtools with method "hvar": the mean of rugosity_of_height_range over squares of this side
// (Torres-Pulliza et al. 2020).
std::optional<double> rugosity_by_height_variation(const HeightGrid& grid, double side_m);

// Length of a chain laid over the ground, link by link, by its length seen from above (Risk 1972;
// McCormick 1994): over the links both ends of which are seen.
struct ProfilePoint {
    double along_m = 0.0;  // the line, seen from above
    double height_m = kUnseen_m;
};
std::optional<double> chain_rugosity(const std::vector<ProfilePoint>& profile);

}  // namespace divemesh::reef
