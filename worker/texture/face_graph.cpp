#include "worker/texture/face_graph.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace divemesh::texture {
namespace {

// An edge of a triangle in the bucket of its lower vertex.
struct Side {
    std::uint32_t upper_vertex = 0;
    std::uint32_t face = 0;

    bool operator<(const Side& other) const {
        return std::pair(upper_vertex, face) < std::pair(other.upper_vertex, other.face);
    }
};

// The edges of all triangles by their lower vertex.
struct Sides {
    std::vector<std::uint32_t> begin;  // of each vertex's bucket
    std::vector<Side> sides;
};

template <typename Visit>
void for_each_side(const types::Mesh& mesh, const Visit& visit) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [lower, upper] =
                std::minmax({mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]});
            if (lower != upper) visit(static_cast<std::uint32_t>(i), lower, upper);
        }
}

Sides sides_of(const types::Mesh& mesh) {
    Sides all;
    all.begin.assign(mesh.vertices.size() + 1, 0);
    for_each_side(
        mesh, [&](std::uint32_t, std::uint32_t lower, std::uint32_t) { ++all.begin[lower + 1]; });
    std::partial_sum(all.begin.begin(), all.begin.end(), all.begin.begin());
    all.sides.resize(all.begin.back());
    std::vector<std::uint32_t> next(all.begin.begin(), all.begin.end() - 1);
    for_each_side(mesh, [&](std::uint32_t face, std::uint32_t lower, std::uint32_t upper) {
        all.sides[next[lower]++] = {upper, face};
    });
    for (std::size_t vertex = 0; vertex + 1 < all.begin.size(); ++vertex)
        std::sort(all.sides.begin() + all.begin[vertex], all.sides.begin() + all.begin[vertex + 1]);
    return all;
}

// Calls visit(face, next_face, lower_vertex, upper_vertex) for consecutive triangles of each edge.
template <typename Visit>
void for_each_pair(const Sides& all, const Visit& visit) {
    for (std::size_t vertex = 0; vertex + 1 < all.begin.size(); ++vertex)
        for (std::uint32_t i = all.begin[vertex] + 1; i < all.begin[vertex + 1]; ++i) {
            const Side& one = all.sides[i - 1];
            const Side& other = all.sides[i];
            if (one.upper_vertex == other.upper_vertex && one.face != other.face)
                visit(one.face, other.face, vertex, one.upper_vertex);
        }
}

}  // namespace

FaceGraph::FaceGraph(const types::Mesh& mesh) : begin_(mesh.triangles.size() + 1, 0) {
    const Sides all = sides_of(mesh);
    for_each_pair(all, [&](std::uint32_t one, std::uint32_t other, std::size_t, std::uint32_t) {
        ++begin_[one + 1];
        ++begin_[other + 1];
    });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    links_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for_each_pair(
        all, [&](std::uint32_t one, std::uint32_t other, std::size_t lower, std::uint32_t upper) {
            const float edge_m = (mesh.vertices[upper] - mesh.vertices[lower]).norm();
            const std::uint32_t there = next[one]++;
            const std::uint32_t back = next[other]++;
            links_[there] = {other, back, edge_m};
            links_[back] = {one, there, edge_m};
        });
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
