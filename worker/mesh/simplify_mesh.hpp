#pragma once

#include <cstdint>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// When simplification stops, whichever limit is reached first.
struct SimplifyLimits {
    double share = 1.0;        // of the triangles to keep
    double max_error_m = 0.0;  // quadric error at which collapsing stops early; 0: no limit
};

// The error of a simplification: distances from each original vertex to the simplified surface.
struct SimplificationError {
    std::int64_t num_triangles_before = 0;
    double rms_m = 0.0;
    double max_m = 0.0;
};

// Returns the mesh with edges collapsed in the order of their quadric error (Garland and Heckbert
// 1997, by meshoptimizer). The remaining vertices keep position, normal, colour, sigma and
// observations; borders stay borders. It may stop short of `share` where a collapse would change
// the topology.
types::Mesh simplify_mesh(const types::Mesh& mesh, const SimplifyLimits& limits);

}  // namespace divemesh::mesh
