#pragma once

#include <cstdint>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// For each triangle the number of its connected component (triangles that share a vertex), in the
// order in which the components first appear.
struct MeshComponents {
    std::vector<std::uint32_t> of_triangle;
    std::vector<double> area_m2;  // of each component
};
MeshComponents find_components(const types::Mesh& mesh);

// Removes the vertices that no triangle uses. Keeps the order.
void remove_unreferenced_vertices(types::Mesh& mesh);

// A mesh without its small components.
struct LargeComponents {
    types::Mesh mesh;
    double removed_m2 = 0.0;
};

// Returns the mesh without components of less than an area, in faces of the voxels that they were
// sampled on, and without unreferenced vertices. Keeps the order. The mesh must have voxel_m.
LargeComponents keep_large_components(types::Mesh mesh, double min_area_voxels);

// The topology that a surface must have before it can be measured, textured or simplified.
struct MeshTopology {
    std::int64_t num_border_edges = 0;       // of only one triangle
    std::int64_t num_nonmanifold_edges = 0;  // of more than two
    std::int64_t num_misoriented_edges = 0;  // used twice in the same direction
    std::int64_t euler_characteristic = 0;   // vertices in use - edges + triangles
    double area_m2 = 0.0;
    double volume_m3 = 0.0;  // signed; positive for a closed surface that faces outward
};

// Measures the topology of a mesh, which may be open or non-manifold.
MeshTopology check_topology(const types::Mesh& mesh);

}  // namespace divemesh::mesh
