#include "worker/io/seamed_mesh.hpp"

#include <unordered_map>

#include "worker/io/mesh_part.hpp"
#include "worker/mesh/simplify_group.hpp"

namespace divemesh::io {
namespace {

// Adds a vertex of a mesh to another one.
void copy_vertex(const types::Mesh& from, std::uint32_t vertex, types::Mesh& mesh) {
    mesh.vertices.push_back(from.vertices[vertex]);
    if (!from.normals.empty()) mesh.normals.push_back(from.normals[vertex]);
    if (!from.colors.empty()) mesh.colors.push_back(from.colors[vertex]);
}

}  // namespace

SeamedMesh::SeamedMesh(const types::Mesh& mesh,
                       const types::TextureMap* texture,
                       std::size_t num_atlases) {
    const auto add = [&](std::int32_t atlas) {
        const MeshPart part = mesh_part(mesh, texture, atlas);
        const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
        for (const std::uint32_t vertex : part.mesh_vertex) copy_vertex(mesh, vertex, mesh_);
        atlas_.resize(mesh_.vertices.size(), atlas);
        uv_.insert(uv_.end(), part.uv.begin(), part.uv.end());
        uv_.resize(mesh_.vertices.size(), Eigen::Vector2f::Zero());
        for (const auto& triangle : part.triangles)
            mesh_.triangles.push_back(
                {first + triangle[0], first + triangle[1], first + triangle[2]});
    };
    for (std::size_t atlas = 0; atlas < num_atlases; ++atlas) add(static_cast<std::int32_t>(atlas));
    add(types::TextureMap::kUntextured);
}

SeamedPart SeamedMesh::part(const Triangles& triangles) const {
    SeamedPart part;
    std::unordered_map<std::uint32_t, std::uint32_t> number_of;
    for (std::array<std::uint32_t, 3> triangle : triangles) {
        part.map.atlas_of_triangle.push_back(atlas_[triangle[0]]);
        part.map.uv.push_back({uv_[triangle[0]], uv_[triangle[1]], uv_[triangle[2]]});
        for (std::uint32_t& vertex : triangle) {
            const auto [found, is_new] = number_of.try_emplace(
                vertex, static_cast<std::uint32_t>(part.mesh.vertices.size()));
            if (is_new) copy_vertex(mesh_, vertex, part.mesh);
            vertex = found->second;
        }
        part.mesh.triangles.push_back(triangle);
    }
    return part;
}

SeamedMesh::Triangles SeamedMesh::simplified(const Triangles& triangles, double max_error_m) const {
    return mesh::collapse_within_border(mesh_.vertices, triangles, max_error_m);
}

}  // namespace divemesh::io
