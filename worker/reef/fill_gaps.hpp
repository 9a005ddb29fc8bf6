#pragma once

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Heights at the nodes that were not seen, from the seen ones around: means over ever wider blocks
// where there is nothing finer, joined linearly (push and pull; Gortler et al. 1996, section 5). Of
// ground behind a tall thing it makes about the shortest surface that there can be. Seen nodes stay
// as they are; a grid without any stays unseen.
HeightGrid gaps_filled(const HeightGrid& grid);

// The same with the ground going on at the level of its foot up to what hides it: the lower end of
// the gap in a node's row and that in its column, the shorter gap weighing more.
HeightGrid gaps_filled_low(const HeightGrid& grid);

}  // namespace divemesh::reef
