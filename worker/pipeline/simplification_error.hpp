#pragma once

#include "worker/mesh/simplify_mesh.hpp"

namespace divemesh::worker {

// Measured by nearest points, not the quadrics that chose the collapses. Neither mesh may be empty.
// The number of threads changes no figure.
SimplificationError simplification_error(const Mesh& original,
                                         const Mesh& simplified,
                                         int num_threads);

}  // namespace divemesh::worker
