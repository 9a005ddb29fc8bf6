#pragma once

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// The surface with its steps, what is steeper than 45 degrees, moved outwards by this much, m: what
// stands up is wider for it; inwards when negative. Dilation (erosion) of the heights by a cone of
// slope 1 (Serra 1982), so that gentler ground stays as it is. Unseen nodes stay unseen.
HeightGrid with_steps_dilated(const HeightGrid& grid, double outwards_m);

}  // namespace divemesh::reef
