#pragma once

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Returns the mesh without triangles that have a vertex of a larger standard deviation, and without
// vertices that no triangle uses any more. Keeps the order. A mesh without sigma stays whole.
types::Mesh cut_by_sigma(types::Mesh mesh, double max_sigma_m);

}  // namespace divemesh::mesh
