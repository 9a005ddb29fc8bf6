#pragma once

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Returns the surface with its steps (parts steeper than 45 degrees) moved outwards by
// `outwards_m`, so that raised parts become wider; inwards if negative. It dilates (erodes) the
// heights by a cone of slope 1 (Serra 1982), so gentler ground stays unchanged. Unseen nodes stay
// unseen.
HeightGrid with_steps_dilated(const HeightGrid& grid, double outwards_m);

}  // namespace divemesh::reef
