#pragma once

#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Halves edges until none is longer than the lesser limit of its ends, without changing the
// surface: triangles on both sides of an edge are split at the same new vertex, which has the mean
// of its ends' attributes and limits. `max_edge_m`: one per vertex, above 0. Edges longer than 2^16
// times their limit stay too long.
types::Mesh split_long_edges(types::Mesh mesh, std::vector<float> max_edge_m);

}  // namespace divemesh::mesh
