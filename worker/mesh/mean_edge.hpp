#pragma once

#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Returns the mean length of the triangles' first edges, m, a measure of the vertex spacing; 0 for
// a mesh without triangles.
double mean_edge_m(const types::Mesh& mesh);

// Returns for each vertex the spacing of the vertices around it, m: the side of a square that two
// of its triangles fill, their mean weighted by area. 0 for a vertex without triangles.
std::vector<float> vertex_spacing_m(const types::Mesh& mesh);

}  // namespace divemesh::mesh
