#pragma once

#include "worker/base/parallel.hpp"
#include "worker/fusion/signed_distance_field.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

struct MeshingSettings {
    int num_threads = 0;  // 0: all cores; the mesh is the same to the byte for any number
    base::ProgressShare progress;
    int num_relaxations = 6;  // only used by surface nets
};

// Returns the mesh of constrained elastic surface nets (Gibson 1998; the paper's mesher): one
// vertex for each sheet of the surface in a cell, two triangles for each crossed lattice edge.
// Vertices begin at the zero of the field, then relax toward the mean of their neighbours, but stay
// in their cell and within one standard deviation of the zero, so that noise is smoothed and the
// shape stays. A vertex per sheet and rejoined folds (Wenger 2013, section 5.3) keep it a manifold.
// Vertices are shared across blocks. Cells with an unknown corner have no surface: holes stay
// holes. Blocks may be of different levels: the mesh has no cracks where they meet.
types::Mesh surface_nets(const fusion::SignedDistanceField& field, const MeshingSettings& settings);

}  // namespace divemesh::mesh
