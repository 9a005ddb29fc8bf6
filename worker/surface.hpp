#pragma once

#include <cstdint>
#include <optional>

#include "worker/volume/mesh.hpp"

namespace divemesh::worker {

// What simplifying a mesh cost: distances from each vertex of the original to the simplified
// surface.
struct SimplificationError {
    std::int64_t num_triangles_before = 0;
    double rms_m = 0.0;
    double max_m = 0.0;
};

// The mesh of step 8 as it is given out.
struct Surface {
    Mesh mesh;
    std::optional<SimplificationError> simplification;  // nothing: all triangles stayed
};

}  // namespace divemesh::worker
