#pragma once

#include <optional>
#include <vector>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Height range within each square of this side of which at least nine tenths are seen, squares
// laid from the grid's origin (habtools hvar).
std::vector<double> height_ranges(const HeightGrid& grid, double side_m);

// Scales from the grid's shorter side down by halves, none shorter than `min_m`.
std::vector<double> halved_scales(const HeightGrid& grid, double min_m);

// D = 3 - slope of log mean height range over log scale (habtools fd, method "hvar", regmethod
// "mean"; Torres-Pulliza et al. 2020). Nothing with fewer than three scales that have a range.
std::optional<double> fractal_dimension_by_height_variation(const HeightGrid& grid, double min_m);

// D = -slope of log number of cubes that hold a sample over log side (habtools fd, method "cubes"),
// the largest cube as long as the surface's longest extent, each next half as long, none shorter
// than `min_m`.
std::optional<double> fractal_dimension_by_cubes(const HeightGrid& grid, double min_m);

// Of the logarithms, least squares; nothing with fewer than three points.
std::optional<double> log_log_slope(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace divemesh::reef
