#pragma once

#include <optional>

#include "worker/mesh/simplify_mesh.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::pipeline {

// The final mesh of step 8.
struct Surface {
    types::Mesh mesh;
    std::optional<mesh::SimplificationError> simplification;  // nullopt: not simplified
};

}  // namespace divemesh::pipeline
