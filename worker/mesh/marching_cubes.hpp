#pragma once

#include "worker/types/mesh.hpp"
#include "worker/fusion/signed_distance_field.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::worker {

// Marching cubes (Lorensen and Cline 1987) with vertices keyed by lattice edge, so that the mesh is
// welded across cells and blocks, and with one rule for ambiguous faces, so that it has no cracks.
// The surface goes exactly through the zeros of the field on the lattice edges. Cells with an
// unknown corner have no surface.
Mesh marching_cubes(const SignedDistanceField& field, const MeshingSettings& settings);

}  // namespace divemesh::worker
