#pragma once

#include <optional>

#include "worker/types/mesh.hpp"
#include "worker/mesh/simplify_mesh.hpp"

namespace divemesh::worker {

// The mesh of step 8 as it is given out.
struct Surface {
    Mesh mesh;
    std::optional<SimplificationError> simplification;  // nothing: all triangles stayed
};

}  // namespace divemesh::worker
