#include "worker/texture/shared_edges.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace divemesh::texture {
namespace {

template <typename Visit>
void for_each_side(const types::Mesh& mesh, const Visit& visit) {
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [lower, upper] =
                std::minmax(mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]);
            if (lower != upper) visit(i, lower, upper);
        }
}

}  // namespace

std::vector<SharedEdge> shared_edges(const types::Mesh& mesh) {
    // Sides are sorted within buckets by their lower vertex, which is much faster than all at once.
    std::vector<std::uint32_t> bucket_begin(mesh.vertices.size() + 1, 0);
    for_each_side(mesh, [&](std::uint32_t, std::uint32_t lower, std::uint32_t) {
        ++bucket_begin[lower + 1];
    });
    std::partial_sum(bucket_begin.begin(), bucket_begin.end(), bucket_begin.begin());
    using Side = std::pair<std::uint32_t, std::uint32_t>;  // upper vertex, triangle
    std::vector<Side> sides(bucket_begin.back());
    std::vector<std::uint32_t> next(bucket_begin.begin(), bucket_begin.end() - 1);
    for_each_side(mesh, [&](std::uint32_t triangle, std::uint32_t lower, std::uint32_t upper) {
        sides[next[lower]++] = {upper, triangle};
    });
    std::vector<SharedEdge> edges;
    edges.reserve(sides.size() / 2);
    for (std::uint32_t lower = 0; lower < mesh.vertices.size(); ++lower) {
        const auto begin = sides.begin() + bucket_begin[lower];
        const auto end = sides.begin() + bucket_begin[lower + 1];
        std::sort(begin, end);
        for (auto side = begin; side != end && side + 1 != end; ++side)
            if (side->first == (side + 1)->first && side->second != (side + 1)->second)
                edges.push_back({{lower, side->first}, {side->second, (side + 1)->second}});
    }
    return edges;
}

}  // namespace divemesh::texture
