#pragma once

#include <optional>

#include "worker/mesh/simplify_mesh.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::pipeline {

// The final mesh of step 8.
struct Surface {
    types::Mesh mesh;
    std::optional<mesh::SimplificationError> simplification;  // nullopt: not simplified
    // Area that was extracted and removed, m2.
    double small_components_m2 = 0.0;
    double cut_by_sigma_m2 = 0.0;
};

}  // namespace divemesh::pipeline
