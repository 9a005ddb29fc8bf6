#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::texture {

// An edge with two triangles that share it.
struct SharedEdge {
    std::array<std::uint32_t, 2> vertices = {};  // the lower one first
    std::array<std::uint32_t, 2> triangles = {};
};

// Returns the edges that different triangles share, in the order of their vertices. Where n
// triangles share an edge it is there n - 1 times, with two of them that follow each other in the
// mesh.
std::vector<SharedEdge> shared_edges(const types::Mesh& mesh);

}  // namespace divemesh::texture
