#include "worker/mesh/split_long_edges.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace divemesh::mesh {
namespace {

constexpr int kMaxRounds = 16;

using Triangle = std::array<std::uint32_t, 3>;
using Edge = std::pair<std::uint32_t, std::uint32_t>;  // the lower vertex first

Edge edge_of(const Triangle& triangle, std::size_t side) {
    return std::minmax(triangle[side], triangle[(side + 1) % 3]);
}

// The edges that are halved in one round, each with its new vertex.
class HalvedEdges {
public:
    HalvedEdges(const types::Mesh& mesh, const std::vector<float>& max_edge_m)
        : first_vertex_(static_cast<std::uint32_t>(mesh.vertices.size())) {
        for (const Triangle& triangle : mesh.triangles)
            for (std::size_t side = 0; side < 3; ++side) {
                const Edge edge = edge_of(triangle, side);
                const float length_m =
                    (mesh.vertices[edge.first] - mesh.vertices[edge.second]).norm();
                if (length_m > std::min(max_edge_m[edge.first], max_edge_m[edge.second]))
                    edges_.push_back(edge);
            }
        std::sort(edges_.begin(), edges_.end());
        edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
    }

    const std::vector<Edge>& edges() const { return edges_; }

    std::optional<std::uint32_t> middle(const Triangle& triangle, std::size_t side) const {
        const Edge edge = edge_of(triangle, side);
        const auto found = std::lower_bound(edges_.begin(), edges_.end(), edge);
        if (found == edges_.end() || *found != edge) return std::nullopt;
        return first_vertex_ + static_cast<std::uint32_t>(found - edges_.begin());
    }

private:
    std::uint32_t first_vertex_;
    std::vector<Edge> edges_;
};

template <typename T, typename Mean>
void add_means(std::vector<T>& values, const std::vector<Edge>& edges, const Mean& mean) {
    if (values.empty()) return;
    values.reserve(values.size() + edges.size());
    for (const Edge& edge : edges) values.push_back(mean(values[edge.first], values[edge.second]));
}

void add_middles(const std::vector<Edge>& edges, types::Mesh& mesh) {
    const auto mean = [](const auto& a, const auto& b) { return 0.5F * (a + b); };
    add_means(mesh.vertices, edges, [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
        return Eigen::Vector3f(0.5F * (a + b));
    });
    add_means(mesh.normals, edges, [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
        return Eigen::Vector3f((a + b).normalized());
    });
    add_means(mesh.colors, edges, [](const types::Color& a, const types::Color& b) {
        types::Color color;
        for (std::size_t i = 0; i < 3; ++i)
            color[i] = static_cast<std::uint8_t>((a[i] + b[i] + 1) / 2);
        return color;
    });
    add_means(mesh.sigma_m, edges, mean);
    add_means(mesh.sigma_local_m, edges, mean);
    add_means(mesh.voxel_m, edges, mean);
    add_means(mesh.num_observations, edges, [](std::uint32_t a, std::uint32_t b) {
        return std::min(a, b);
    });
}

// Adds the parts of a triangle. If any side is halved, that from the first corner to the second is.
void add_parts(const Triangle& corners,
               const std::array<std::optional<std::uint32_t>, 3>& middles,
               std::vector<Triangle>& parts) {
    const auto [a, b, c] = corners;
    const auto [ab, bc, ca] = middles;
    if (!ab) {
        parts.push_back(corners);
    } else if (bc && ca) {
        parts.insert(parts.end(), {{a, *ab, *ca}, {*ab, b, *bc}, {*ca, *bc, c}, {*ab, *bc, *ca}});
    } else if (bc) {
        parts.insert(parts.end(), {{*ab, b, *bc}, {a, *ab, *bc}, {a, *bc, c}});
    } else if (ca) {
        parts.insert(parts.end(), {{a, *ab, *ca}, {*ab, b, c}, {*ab, c, *ca}});
    } else {
        parts.insert(parts.end(), {{a, *ab, c}, {*ab, b, c}});
    }
}

std::vector<Triangle> split(const std::vector<Triangle>& triangles, const HalvedEdges& halved) {
    std::vector<Triangle> parts;
    parts.reserve(triangles.size() + 3 * halved.edges().size());
    for (const Triangle& triangle : triangles) {
        std::array<std::optional<std::uint32_t>, 3> middles;
        for (std::size_t side = 0; side < 3; ++side) middles[side] = halved.middle(triangle, side);
        std::size_t first = 0;
        while (first < 2 && !middles[first]) ++first;
        if (!middles[first]) first = 0;
        const auto turned = [&](const auto& values) {
            auto result = values;
            for (std::size_t i = 0; i < 3; ++i) result[i] = values[(first + i) % 3];
            return result;
        };
        add_parts(turned(triangle), turned(middles), parts);
    }
    return parts;
}

}  // namespace

types::Mesh split_long_edges(types::Mesh mesh, std::vector<float> max_edge_m) {
    for (int round = 0; round < kMaxRounds; ++round) {
        const HalvedEdges halved(mesh, max_edge_m);
        if (halved.edges().empty()) break;
        mesh.triangles = split(mesh.triangles, halved);
        add_middles(halved.edges(), mesh);
        add_means(max_edge_m, halved.edges(), [](float a, float b) { return 0.5F * (a + b); });
    }
    return mesh;
}

}  // namespace divemesh::mesh
