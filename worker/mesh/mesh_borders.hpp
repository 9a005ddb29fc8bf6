#pragma once

#include <cstdint>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// The borders of a surface. Border edges (of only one triangle) form closed loops. The longest loop
// of a connected component is its outer edge, the others are holes: places that were not seen well
// enough, which stay open.
struct MeshBorders {
    std::int64_t num_holes = 0;
    double hole_area_m2 = 0.0;  // of all holes, each by the vector area of its loop
    double largest_hole_m2 = 0.0;
    double outer_edge_m = 0.0;  // length of all outer edges
};
MeshBorders find_borders(const types::Mesh& mesh);

}  // namespace divemesh::mesh
