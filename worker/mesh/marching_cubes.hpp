#pragma once

#include "worker/fusion/signed_distance_field.hpp"
#include "worker/mesh/surface_nets.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Returns the mesh of marching cubes (Lorensen and Cline 1987). Vertices are keyed by lattice edge,
// so that the mesh is welded across cells and blocks, and ambiguous faces follow one rule, so that
// it has no cracks. The surface passes exactly through the zeros of the field on the lattice edges.
// Cells with an unknown corner have no surface. Throws Error{InvalidArgument} if the field has
// blocks of several levels.
types::Mesh marching_cubes(const fusion::SignedDistanceField& field,
                           const MeshingSettings& settings);

}  // namespace divemesh::mesh
