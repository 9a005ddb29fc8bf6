#include "worker/mesh/simplify_group.hpp"

#include <algorithm>
#include <meshoptimizer.h>

namespace divemesh::mesh {
namespace {

using Edge = std::array<std::uint32_t, 2>;
using Triangle = std::array<std::uint32_t, 3>;

// Numbers the vertices of the triangles from 0. Returns their numbers in the mesh.
std::vector<std::uint32_t> renumber(std::vector<Triangle>& triangles) {
    std::vector<std::uint32_t> used;
    used.reserve(3 * triangles.size());
    for (const Triangle& triangle : triangles)
        used.insert(used.end(), triangle.begin(), triangle.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (Triangle& triangle : triangles)
        for (std::uint32_t& vertex : triangle)
            vertex = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), vertex) -
                                                used.begin());
    return used;
}

std::vector<Eigen::Vector3f> positions_of(const std::vector<Eigen::Vector3f>& vertices,
                                          const std::vector<std::uint32_t>& used) {
    std::vector<Eigen::Vector3f> positions;
    positions.reserve(used.size());
    for (const std::uint32_t vertex : used) positions.push_back(vertices[vertex]);
    return positions;
}

std::vector<Triangle> collapse(const std::vector<Eigen::Vector3f>& vertices,
                               const std::vector<Triangle>& triangles,
                               double max_error_m) {
    static_assert(sizeof(Triangle) == 3 * sizeof(unsigned));
    constexpr std::size_t kStride = sizeof(Eigen::Vector3f);
    const float* positions = vertices.front().data();
    const float extent_m = meshopt_simplifyScale(positions, vertices.size(), kStride);
    if (!(extent_m > 0.0F)) return triangles;
    std::vector<Triangle> fewer(triangles.size());
    const std::size_t num_left = meshopt_simplify(fewer.front().data(),
                                                  triangles.front().data(),
                                                  3 * triangles.size(),
                                                  positions,
                                                  vertices.size(),
                                                  kStride,
                                                  0,
                                                  static_cast<float>(max_error_m) / extent_m,
                                                  meshopt_SimplifyLockBorder,
                                                  nullptr);
    fewer.resize(num_left / 3);
    return fewer;
}

// The edges of some triangles in their order, each with the number of its triangles.
struct CountedEdges {
    std::vector<Edge> edges;
    std::vector<std::size_t> num_triangles;
};

CountedEdges count_edges(const std::vector<Triangle>& triangles) {
    std::vector<Edge> sides;
    sides.reserve(3 * triangles.size());
    for (const Triangle& triangle : triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [low, high] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
            sides.push_back({low, high});
        }
    std::sort(sides.begin(), sides.end());
    CountedEdges counted;
    for (const Edge& side : sides) {
        if (counted.edges.empty() || counted.edges.back() != side) {
            counted.edges.push_back(side);
            counted.num_triangles.push_back(0);
        }
        ++counted.num_triangles.back();
    }
    return counted;
}

bool is_manifold(const CountedEdges& counted) {
    return std::all_of(counted.num_triangles.begin(),
                       counted.num_triangles.end(),
                       [](std::size_t num) { return num <= 2; });
}

void list_outer_edges(const CountedEdges& counted,
                      std::size_t num_vertices,
                      SimplifiedGroup& group) {
    std::vector<bool> is_at_border(num_vertices, false);
    for (std::size_t i = 0; i < counted.edges.size(); ++i)
        if (counted.num_triangles[i] == 1)
            for (const std::uint32_t vertex : counted.edges[i]) is_at_border[vertex] = true;
    for (std::size_t i = 0; i < counted.edges.size(); ++i) {
        const Edge& edge = counted.edges[i];
        if (counted.num_triangles[i] == 1)
            group.border.push_back(edge);
        else if (is_at_border[edge[0]] && is_at_border[edge[1]])
            group.chords.push_back(edge);
    }
}

template <std::size_t kSize>
void rename(const std::vector<std::uint32_t>& names,
            std::vector<std::array<std::uint32_t, kSize>>& entries) {
    for (auto& entry : entries)
        for (std::uint32_t& vertex : entry) vertex = names[vertex];
}

}  // namespace

std::optional<SimplifiedGroup> simplify_group(const std::vector<Eigen::Vector3f>& vertices,
                                              const std::vector<Triangle>& triangles,
                                              double max_error_m) {
    SimplifiedGroup group{triangles, {}, {}};
    if (triangles.empty()) return group;
    const std::vector<std::uint32_t> used = renumber(group.triangles);
    if (max_error_m > 0.0)
        group.triangles = collapse(positions_of(vertices, used), group.triangles, max_error_m);
    const CountedEdges counted = count_edges(group.triangles);
    if (max_error_m > 0.0 && !is_manifold(counted)) return std::nullopt;
    list_outer_edges(counted, used.size(), group);
    rename(used, group.triangles);
    rename(used, group.border);
    rename(used, group.chords);
    return group;
}

std::vector<Triangle> collapse_within_border(const std::vector<Eigen::Vector3f>& vertices,
                                             const std::vector<Triangle>& triangles,
                                             double max_error_m) {
    if (triangles.empty()) return {};
    std::vector<Triangle> collapsed = triangles;
    const std::vector<std::uint32_t> used = renumber(collapsed);
    collapsed = collapse(positions_of(vertices, used), collapsed, max_error_m);
    rename(used, collapsed);
    return collapsed;
}

}  // namespace divemesh::mesh
