#include "worker/io/mesh_part.hpp"

#include <limits>

namespace divemesh::io {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Numbers pairs of vertex and texture coordinates in the order in which they first appear.
class PartVertices {
public:
    PartVertices(std::size_t num_mesh_vertices, MeshPart& part)
        : part_(part), latest_(num_mesh_vertices, kNone) {}

    // `uv` is null for an untextured part.
    std::uint32_t number_of(std::uint32_t mesh_vertex, const Eigen::Vector2f* uv) {
        for (std::uint32_t i = latest_[mesh_vertex]; i != kNone; i = previous_[i])
            if (uv == nullptr || part_.uv[i] == *uv) return i;
        const auto number = static_cast<std::uint32_t>(part_.mesh_vertex.size());
        part_.mesh_vertex.push_back(mesh_vertex);
        if (uv != nullptr) part_.uv.push_back(*uv);
        previous_.push_back(latest_[mesh_vertex]);
        latest_[mesh_vertex] = number;
        return number;
    }

private:
    MeshPart& part_;
    std::vector<std::uint32_t> latest_;    // of a vertex of the mesh, its last number
    std::vector<std::uint32_t> previous_;  // of a number, the one before of the same vertex
};

}  // namespace

MeshPart mesh_part(const types::Mesh& mesh, const types::TextureMap* texture, std::int32_t atlas) {
    MeshPart part;
    PartVertices vertices(mesh.vertices.size(), part);
    const bool is_textured = atlas != types::TextureMap::kUntextured;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto of_triangle =
            texture == nullptr ? types::TextureMap::kUntextured : texture->atlas_of_triangle[i];
        if (of_triangle != atlas) continue;
        auto& triangle = part.triangles.emplace_back();
        for (std::size_t corner = 0; corner < 3; ++corner)
            triangle[corner] = vertices.number_of(mesh.triangles[i][corner],
                                                  is_textured ? &texture->uv[i][corner] : nullptr);
    }
    return part;
}

}  // namespace divemesh::io
