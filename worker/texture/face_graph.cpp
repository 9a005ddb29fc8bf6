#include "worker/texture/face_graph.hpp"

#include <bit>
#include <numeric>

#include "worker/texture/shared_edges.hpp"

namespace divemesh::texture {

FaceGraph::FaceGraph(const types::Mesh& mesh) : begin_(mesh.triangles.size() + 1, 0) {
    const std::vector<SharedEdge> edges = shared_edges(mesh);
    for (const SharedEdge& edge : edges)
        for (const std::uint32_t face : edge.triangles) ++begin_[face + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    links_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (const auto& [vertices, faces] : edges) {
        const float edge_m = (mesh.vertices[vertices[1]] - mesh.vertices[vertices[0]]).norm();
        const std::uint32_t there = next[faces[0]]++;
        const std::uint32_t back = next[faces[1]]++;
        links_[there] = {faces[1], back, edge_m};
        links_[back] = {faces[0], there, edge_m};
    }
}

std::vector<std::vector<std::uint32_t>> independent_faces(const FaceGraph& graph) {
    constexpr std::uint8_t kNoGroup = 0xff;
    std::vector<std::uint8_t> group_of(graph.num_faces(), kNoGroup);
    std::vector<std::vector<std::uint32_t>> groups;
    for (std::size_t face = 0; face < graph.num_faces(); ++face) {
        std::uint32_t taken = 0;  // a bit for each group; a triangle has at most six neighbours
        for (const FaceLink& link : graph.links(face))
            if (group_of[link.face] != kNoGroup) taken |= 1U << group_of[link.face];
        const auto group = static_cast<std::uint8_t>(std::countr_one(taken));
        group_of[face] = group;
        if (group == groups.size()) groups.emplace_back();
        groups[group].push_back(static_cast<std::uint32_t>(face));
    }
    return groups;
}

}  // namespace divemesh::texture
