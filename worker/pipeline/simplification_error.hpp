#pragma once

#include "worker/base/observer.hpp"
#include "worker/mesh/simplify_mesh.hpp"

namespace divemesh::pipeline {

// Returns the error measured by nearest points, not by the quadrics that chose the collapses.
// Neither mesh may be empty. The result does not depend on the number of threads.
mesh::SimplificationError simplification_error(const types::Mesh& original,
                                               const types::Mesh& simplified,
                                               int num_threads,
                                               const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
