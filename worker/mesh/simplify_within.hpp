#pragma once

#include <vector>

#include "worker/base/observer.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Returns the mesh with as few triangles as meshoptimizer finds while its quadric error (the root
// mean square distance from the planes that a vertex replaces) stays below the tolerance, m, of
// every vertex around, so that accurate parts keep more triangles than uncertain ones. As that is a
// mean, single places may be farther away. There must be one tolerance per vertex; where it is not
// a positive number, no triangle changes. The remaining vertices keep position and attributes; all
// vertices at a border remain, and no edge gets more than two triangles. The result does not depend
// on the number of threads.
types::Mesh simplify_within(const types::Mesh& mesh,
                            const std::vector<float>& tolerance_m,
                            int num_threads,
                            const base::ProgressCallback& progress);

}  // namespace divemesh::mesh
