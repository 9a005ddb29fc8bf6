#pragma once

#include <cstdint>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Gives vertices without a colour the mean of their neighbours', from the coloured ones outward: a
// frame may measure the depth of a place that no frame coloured. Vertices that no coloured one
// reaches keep theirs. `has_color`: one per vertex, 0 or 1.
void fill_colors(types::Mesh& mesh, std::vector<std::uint8_t> has_color);

}  // namespace divemesh::mesh
