#pragma once

#include <optional>

#include "worker/mesh/simplify_mesh.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::pipeline {

// The mesh of step 8 as it is given out.
struct Surface {
    types::Mesh mesh;
    std::optional<mesh::SimplificationError> simplification;  // nothing: all triangles stayed
};

}  // namespace divemesh::pipeline
