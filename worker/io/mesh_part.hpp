#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::io {

// The triangles of a mesh that share one atlas, with vertices of their own. A vertex of the mesh is
// repeated where its texture coordinates differ from triangle to triangle.
struct MeshPart {
    std::vector<std::uint32_t> mesh_vertex;  // for each vertex its number in the mesh
    std::vector<Eigen::Vector2f> uv;         // one per vertex; empty if the part is untextured
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Returns the part of an atlas, or of kUntextured; without texture (null) all triangles are that.
MeshPart mesh_part(const types::Mesh& mesh, const types::TextureMap* texture, std::int32_t atlas);

}  // namespace divemesh::io
