#pragma once

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Returns the mean length of the triangles' first edges, m, a measure of the vertex spacing; 0 for
// a mesh without triangles.
double mean_edge_m(const types::Mesh& mesh);

}  // namespace divemesh::mesh
