#pragma once

#include <cstdint>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// For each triangle the number of its connected component (triangles that share a vertex), in the
// order in which components first appear.
struct MeshComponents {
    std::vector<std::uint32_t> of_triangle;
    std::vector<double> area_m2;  // of each component
};
MeshComponents find_components(const types::Mesh& mesh);

// Takes out the vertices that no triangle names. Order is kept.
void remove_unreferenced_vertices(types::Mesh& mesh);

// The mesh without components of less than `min_area_m2` and without unused vertices. Order is
// kept.
types::Mesh keep_large_components(types::Mesh mesh, double min_area_m2);

// What a surface has to be before it can be measured, textured or simplified.
struct MeshTopology {
    std::int64_t num_border_edges = 0;       // of one triangle alone
    std::int64_t num_nonmanifold_edges = 0;  // of more than two
    std::int64_t num_misoriented_edges = 0;  // run through twice in the same direction
    std::int64_t euler_characteristic = 0;   // vertices in use - edges + triangles
    double area_m2 = 0.0;
    double volume_m3 = 0.0;  // signed; of a closed surface, positive when it faces outward
};
MeshTopology check_topology(const types::Mesh& mesh);

}  // namespace divemesh::mesh
