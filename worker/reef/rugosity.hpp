#pragma once

#include <optional>
#include <vector>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Areas of the triangles between the samples of a grid, the mean of both ways to split a cell. A
// cell with three seen corners counts with one triangle.
struct GridArea {
    double surface_m2 = 0.0;
    double planar_m2 = 0.0;
};
GridArea grid_area(const HeightGrid& grid);
// Returns rugosity R: surface over planar area of grid_area() (habtools rg; Torres-Pulliza et al.
// 2020, with samples in place of means over cells); nullopt without triangles. The resolution is
// the grid's spacing.
std::optional<double> rugosity(const HeightGrid& grid);

// Returns rg of habtools with method "hvar": the mean of rugosity_of_height_range over squares of
// this side (Torres-Pulliza et al. 2020).
std::optional<double> rugosity_by_height_variation(const HeightGrid& grid, double side_m);

// A point of a profile.
struct ProfilePoint {
    double along_m = 0.0;  // position along the line, seen from above
    double height_m = kUnseen_m;
};
// Returns chain rugosity: the length of a chain laid over the ground, link by link, divided by its
// length seen from above (Risk 1972; McCormick 1994), over links with both ends seen; nullopt
// without such links.
std::optional<double> chain_rugosity(const std::vector<ProfilePoint>& profile);

}  // namespace divemesh::reef
