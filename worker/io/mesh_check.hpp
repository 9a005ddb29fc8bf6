#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Throws Error{InvalidArgument} when a triangle names a vertex that is not there, a coordinate is
// not finite, or an attribute has another length than the vertices.
void check_mesh(const types::Mesh& mesh);

// The mesh's normals at unit length; where there is none or it is degenerate, the area-weighted
// mean of the triangles around the vertex; upward where that is degenerate too.
std::vector<Eigen::Vector3f> unit_normals(const types::Mesh& mesh);

}  // namespace divemesh::io
