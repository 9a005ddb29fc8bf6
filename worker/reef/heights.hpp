#pragma once

#include <optional>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Highest minus lowest sample (height range, H; habtools hr); nothing where none is seen.
std::optional<double> height_range(const HeightGrid& grid);

// Between the surface and the plane, m3: what rises above it less what lies below it, one spacing
// square a sample, half of it on the grid's sides and a quarter at its corners.
double volume_over_plane(const HeightGrid& grid);

}  // namespace divemesh::reef
