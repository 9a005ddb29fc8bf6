#pragma once

#include <optional>
#include <vector>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Returns the height range within each square of this side of which at least nine tenths are seen.
// The squares start at the grid's origin (habtools hvar).
std::vector<double> height_ranges(const HeightGrid& grid, double side_m);

// Returns scales from the grid's shorter side downwards, each half the one before, none below
// `min_m`.
std::vector<double> halved_scales(const HeightGrid& grid, double min_m);

// Returns D = 3 - slope of log mean height range over log scale (habtools fd, method "hvar",
// regmethod "mean"; Torres-Pulliza et al. 2020); nullopt with fewer than three scales that have a
// range.
std::optional<double> fractal_dimension_by_height_variation(const HeightGrid& grid, double min_m);

// Returns D = -slope of log number of cubes that contain a sample over log side (habtools fd,
// method "cubes"). The largest cube is as long as the surface's longest extent, each next half as
// long, none below `min_m`.
std::optional<double> fractal_dimension_by_cubes(const HeightGrid& grid, double min_m);

// Returns the least-squares slope of log y over log x; nullopt with fewer than three points.
std::optional<double> log_log_slope(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace divemesh::reef
