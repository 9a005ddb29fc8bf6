#include "worker/mesh/mesh_components.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "worker/base/disjoint_sets.hpp"
#include "worker/types/triangle_area.hpp"

namespace divemesh::mesh {
namespace {

// `kept` must be sorted.
template <typename T>
void keep_entries(std::vector<T>& values, const std::vector<std::uint32_t>& kept) {
    if (values.empty()) return;
    for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
    values.resize(kept.size());
}

// Sums an area of each triangle over its component.
template <typename Area>
MeshComponents sum_components(const types::Mesh& mesh, const Area& area) {
    base::DisjointSets sets(mesh.vertices.size());
    for (const auto& triangle : mesh.triangles)
        for (int k = 1; k < 3; ++k) sets.join(triangle[0], triangle[k]);
    constexpr std::uint32_t kNone = 0xffffffffU;
    std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
    MeshComponents components;
    components.of_triangle.reserve(mesh.triangles.size());
    for (const auto& triangle : mesh.triangles) {
        std::uint32_t& component = number[sets.find(triangle[0])];
        if (component == kNone) {
            component = static_cast<std::uint32_t>(components.area_m2.size());
            components.area_m2.push_back(0.0);
        }
        components.of_triangle.push_back(component);
        components.area_m2[component] += area(triangle);
    }
    return components;
}

// Returns the area in faces of the mean voxel of the corners.
double area_in_voxels(const types::Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
    double voxel_m = 0.0;
    for (const std::uint32_t vertex : triangle)
        voxel_m += static_cast<double>(mesh.voxel_m[vertex]) / 3.0;
    return types::triangle_area_m2(mesh, triangle) / (voxel_m * voxel_m);
}

}  // namespace

MeshComponents find_components(const types::Mesh& mesh) {
    return sum_components(
        mesh, [&](const auto& triangle) { return types::triangle_area_m2(mesh, triangle); });
}

void remove_unreferenced_vertices(types::Mesh& mesh) {
    std::vector<std::uint32_t> renumbered(mesh.vertices.size(), 0);
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle) renumbered[vertex] = 1;
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < renumbered.size(); ++i)
        if (renumbered[i] != 0) {
            renumbered[i] = static_cast<std::uint32_t>(kept.size());
            kept.push_back(i);
        }
    for (auto& triangle : mesh.triangles)
        for (std::uint32_t& vertex : triangle) vertex = renumbered[vertex];
    keep_entries(mesh.vertices, kept);
    keep_entries(mesh.normals, kept);
    keep_entries(mesh.colors, kept);
    keep_entries(mesh.sigma_m, kept);
    keep_entries(mesh.sigma_local_m, kept);
    keep_entries(mesh.num_observations, kept);
    keep_entries(mesh.voxel_m, kept);
}

LargeComponents keep_large_components(types::Mesh mesh, double min_area_voxels) {
    const MeshComponents components =
        sum_components(mesh, [&](const auto& triangle) { return area_in_voxels(mesh, triangle); });
    double removed_m2 = 0.0;
    std::size_t num_kept = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (components.area_m2[components.of_triangle[i]] >= min_area_voxels)
            mesh.triangles[num_kept++] = mesh.triangles[i];
        else
            removed_m2 += types::triangle_area_m2(mesh, mesh.triangles[i]);
    }
    mesh.triangles.resize(num_kept);
    remove_unreferenced_vertices(mesh);
    return {std::move(mesh), removed_m2};
}

MeshTopology check_topology(const types::Mesh& mesh) {
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    // Sorted ends; whether the edge is traversed in that order.
    std::vector<std::pair<Edge, bool>> sides;
    std::vector<bool> used(mesh.vertices.size(), false);
    MeshTopology topology;
    for (const auto& triangle : mesh.triangles) {
        topology.area_m2 += types::triangle_area_m2(mesh, triangle);
        topology.volume_m3 += mesh.vertices[triangle[0]].cast<double>().dot(
                                  mesh.vertices[triangle[1]].cast<double>().cross(
                                      mesh.vertices[triangle[2]].cast<double>())) /
                              6.0;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
            used[a] = true;
            sides.push_back({std::minmax(a, b), a < b});
        }
    }
    std::sort(sides.begin(), sides.end());
    std::int64_t num_edges = 0;
    for (std::size_t i = 0; i < sides.size(); ++num_edges) {
        std::size_t end = i;
        std::int64_t forward = 0;
        for (; end < sides.size() && sides[end].first == sides[i].first; ++end)
            forward += sides[end].second ? 1 : 0;
        const auto num = static_cast<std::int64_t>(end - i);
        if (num == 1) ++topology.num_border_edges;
        if (num > 2) ++topology.num_nonmanifold_edges;
        if (num == 2 && forward != 1) ++topology.num_misoriented_edges;
        i = end;
    }
    topology.euler_characteristic = std::count(used.begin(), used.end(), true) - num_edges +
                                    static_cast<std::int64_t>(mesh.triangles.size());
    return topology;
}

}  // namespace divemesh::mesh
