#pragma once

#include "worker/mesh/simplify_mesh.hpp"

namespace divemesh::pipeline {

// Measured by nearest points, not the quadrics that chose the collapses. Neither mesh may be empty.
// The number of threads changes no figure.
mesh::SimplificationError simplification_error(const types::Mesh& original,
                                               const types::Mesh& simplified,
                                               int num_threads);

}  // namespace divemesh::pipeline
