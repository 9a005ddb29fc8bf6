#include "worker/mesh/mesh_borders.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "worker/mesh/mesh_components.hpp"

namespace divemesh::mesh {
namespace {

// A border edge in the direction of its triangle.
struct BorderEdge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t component = 0;

    bool operator<(const BorderEdge& other) const {
        return std::pair(from, to) < std::pair(other.from, other.to);
    }
};

template <typename Visit>
void for_each_edge(const types::Mesh& mesh, Visit&& visit) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (int k = 0; k < 3; ++k) visit(i, mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]);
}

// Returns the border edges, sorted by their start. Edges are counted in buckets by their lower
// vertex: sorting all of them would take ten times as long.
std::vector<BorderEdge> border_edges(const types::Mesh& mesh) {
    std::vector<std::uint32_t> bucket_end(mesh.vertices.size() + 1, 0);
    for_each_edge(mesh, [&](std::size_t, std::uint32_t from, std::uint32_t to) {
        ++bucket_end[std::min(from, to) + 1];
    });
    std::partial_sum(bucket_end.begin(), bucket_end.end(), bucket_end.begin());
    std::vector<std::uint32_t> greater(3 * mesh.triangles.size());
    for_each_edge(mesh, [&](std::size_t, std::uint32_t from, std::uint32_t to) {
        greater[bucket_end[std::min(from, to)]++] = std::max(from, to);
    });  // bucket_end[v] has moved from the start to the end of v's bucket
    const MeshComponents components = find_components(mesh);
    std::vector<BorderEdge> border;
    for_each_edge(mesh, [&](std::size_t triangle, std::uint32_t from, std::uint32_t to) {
        const std::uint32_t lesser = std::min(from, to);
        const auto begin = greater.begin() + (lesser == 0 ? 0 : bucket_end[lesser - 1]);
        if (std::count(begin, greater.begin() + bucket_end[lesser], std::max(from, to)) == 1)
            border.push_back({from, to, components.of_triangle[triangle]});
    });
    std::sort(border.begin(), border.end());
    return border;
}

struct Loop {
    std::uint32_t component = 0;
    double length_m = 0.0;
    double area_m2 = 0.0;
};

std::vector<Loop> trace_loops(const types::Mesh& mesh, const std::vector<BorderEdge>& edges) {
    std::vector<bool> used(edges.size(), false);
    // Where loops touch in a vertex, any continuation closes a loop, so the first unused edge is
    // taken.
    const auto next_from = [&](std::uint32_t vertex) {
        auto at = std::lower_bound(edges.begin(), edges.end(), BorderEdge{vertex, 0, 0});
        while (at != edges.end() && at->from == vertex && used[at - edges.begin()]) ++at;
        return at != edges.end() && at->from == vertex ? at : edges.end();
    };
    std::vector<Loop> loops;
    for (std::size_t start = 0; start < edges.size(); ++start) {
        if (used[start]) continue;
        Loop loop{.component = edges[start].component};
        const Eigen::Vector3d origin = mesh.vertices[edges[start].from].cast<double>();
        Eigen::Vector3d area = Eigen::Vector3d::Zero();
        for (auto at = edges.begin() + static_cast<std::ptrdiff_t>(start); at != edges.end();
             at = next_from(at->to)) {
            used[at - edges.begin()] = true;
            const Eigen::Vector3d a = mesh.vertices[at->from].cast<double>() - origin;
            const Eigen::Vector3d b = mesh.vertices[at->to].cast<double>() - origin;
            loop.length_m += (b - a).norm();
            area += 0.5 * a.cross(b);
        }
        loop.area_m2 = area.norm();
        loops.push_back(loop);
    }
    return loops;
}

}  // namespace

MeshBorders find_borders(const types::Mesh& mesh) {
    std::vector<Loop> loops = trace_loops(mesh, border_edges(mesh));
    std::stable_sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) {
        return std::pair(a.component, -a.length_m) < std::pair(b.component, -b.length_m);
    });
    MeshBorders borders;
    for (std::size_t i = 0; i < loops.size(); ++i) {
        if (i == 0 || loops[i].component != loops[i - 1].component) {
            borders.outer_edge_m += loops[i].length_m;
            continue;
        }
        ++borders.num_holes;
        borders.hole_area_m2 += loops[i].area_m2;
        borders.largest_hole_m2 = std::max(borders.largest_hole_m2, loops[i].area_m2);
    }
    return borders;
}

}  // namespace divemesh::mesh
