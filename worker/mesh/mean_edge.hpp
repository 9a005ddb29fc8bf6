#pragma once

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Of each triangle's first edge, m: how far apart the vertices are. 0 without triangles.
double mean_edge_m(const types::Mesh& mesh);

}  // namespace divemesh::mesh
