#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Throws Error{InvalidArgument} if a triangle uses a vertex that does not exist, a coordinate is
// not finite, or an attribute differs in length from the vertices.
void check_mesh(const types::Mesh& mesh);

// Returns the mesh's normals at unit length. A missing or degenerate normal is replaced by the
// area-weighted mean of the triangles around the vertex, or by the upward vector if that is
// degenerate too.
std::vector<Eigen::Vector3f> unit_normals(const types::Mesh& mesh);

}  // namespace divemesh::io
