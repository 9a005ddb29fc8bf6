#pragma once

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Fills in heights at unseen nodes from the seen nodes around: means over ever wider blocks where
// no finer mean is known, joined linearly (push and pull; Gortler et al. 1996, section 5). Behind a
// tall object it gives nearly the smallest possible surface. Seen nodes stay unchanged; a grid
// without seen nodes stays unseen.
HeightGrid gaps_filled(const HeightGrid& grid);

// Does the same, but continues the ground at the level of its foot up to the object that hides it:
// at the lower end of the gap in the node's row and in its column, where the shorter gap has more
// weight.
HeightGrid gaps_filled_low(const HeightGrid& grid);

}  // namespace divemesh::reef
