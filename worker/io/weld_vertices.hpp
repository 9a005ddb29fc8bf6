#pragma once

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Makes one vertex of those whose position and normal are equal, in the order in which they first
// appear. Of their colours the lowest (red first) remains, as white stands for none. The mesh has
// at most positions, normals, colours and triangles.
void weld_vertices(types::Mesh& mesh);

}  // namespace divemesh::io
