#pragma once

#include <optional>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Returns highest minus lowest sample (height range, H; habtools hr), m; nullopt if none is seen.
std::optional<double> height_range(const HeightGrid& grid);

// Returns the area of the seen samples, m2. A sample stands for one spacing square, half of it on
// the grid's sides and a quarter at its corners.
double planar_area_m2(const HeightGrid& grid);

// Returns the volume between the surface and the plane over these squares, m3: above the plane
// minus below it.
double volume_over_plane(const HeightGrid& grid);

}  // namespace divemesh::reef
