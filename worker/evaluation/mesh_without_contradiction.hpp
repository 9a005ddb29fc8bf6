#pragma once

#include "worker/io/reconstruction_folder.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

// Returns the folder's mesh with the sigmas that make its shape uncertain. A contradicted scale
// moves all vertices together, so it is no noise of a surface; scale_sigma() states it. Reads the
// trajectory only where the scale is contradicted.
types::Mesh mesh_without_contradiction(const io::ReconstructionFolder& folder);

}  // namespace divemesh::evaluation
