#include "worker/mesh/simplify_group.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <meshoptimizer.h>
#include <numeric>

namespace divemesh::mesh {
namespace {

using Edge = std::array<std::uint32_t, 2>;
using Triangle = std::array<std::uint32_t, 3>;

// Numbers vertices in the order in which they first appear.
class FirstAppearance {
public:
    explicit FirstAppearance(std::size_t max_corners)
        : slots_(std::bit_ceil(2 * max_corners), Slot{kNone, 0}) {}

    std::uint32_t number_of(std::uint32_t vertex) {
        // Multiplying by 2^32 over the golden ratio spreads neighbours over the slots.
        std::size_t i = (vertex * 2'654'435'769U) & (slots_.size() - 1);
        while (slots_[i].vertex != vertex) {
            if (slots_[i].vertex == kNone) {
                slots_[i] = {vertex, static_cast<std::uint32_t>(vertices_.size())};
                vertices_.push_back(vertex);
                break;
            }
            i = (i + 1) & (slots_.size() - 1);
        }
        return slots_[i].number;
    }
    const std::vector<std::uint32_t>& vertices() const { return vertices_; }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    struct Slot {
        std::uint32_t vertex;
        std::uint32_t number;
    };
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> vertices_;
};

// Numbers the vertices of the triangles from 0, in their order. Returns their numbers in the mesh.
std::vector<std::uint32_t> renumber(std::vector<Triangle>& triangles) {
    FirstAppearance first(3 * triangles.size());
    for (Triangle& triangle : triangles)
        for (std::uint32_t& vertex : triangle) vertex = first.number_of(vertex);
    std::vector<std::uint32_t> used = first.vertices();
    std::sort(used.begin(), used.end());
    std::vector<std::uint32_t> rank(used.size());
    for (std::size_t i = 0; i < used.size(); ++i)
        rank[first.number_of(used[i])] = static_cast<std::uint32_t>(i);
    for (Triangle& triangle : triangles)
        for (std::uint32_t& vertex : triangle) vertex = rank[vertex];
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

// Calls use(low, high) for the sides of the triangles.
template <typename Use>
void for_each_side(const std::vector<Triangle>& triangles, const Use& use) {
    for (const Triangle& triangle : triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [low, high] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
            use(low, high);
        }
}

// Sorts the sides by their lower vertex at first, which few of them share.
CountedEdges count_edges(const std::vector<Triangle>& triangles, std::size_t num_vertices) {
    std::vector<std::uint32_t> end(num_vertices + 1, 0);
    for_each_side(triangles, [&](std::uint32_t low, std::uint32_t) { ++end[low + 1]; });
    std::partial_sum(end.begin(), end.end(), end.begin());
    std::vector<std::uint32_t> highs(3 * triangles.size());
    for_each_side(triangles,
                  [&](std::uint32_t low, std::uint32_t high) { highs[end[low]++] = high; });
    CountedEdges counted;
    counted.edges.reserve(highs.size());
    counted.num_triangles.reserve(highs.size());
    auto begin = highs.begin();
    for (std::uint32_t low = 0; low < num_vertices; ++low) {
        const auto next = highs.begin() + end[low];
        std::sort(begin, next);
        for (auto high = begin; high != next; ++high) {
            if (high == begin || *high != *(high - 1)) {
                counted.edges.push_back({low, *high});
                counted.num_triangles.push_back(0);
            }
            ++counted.num_triangles.back();
        }
        begin = next;
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
    const CountedEdges counted = count_edges(group.triangles, used.size());
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
