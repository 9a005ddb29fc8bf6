#include "worker/mesh/mean_edge.hpp"

#include <cmath>

#include "worker/types/triangle_area.hpp"

namespace divemesh::mesh {

double mean_edge_m(const types::Mesh& mesh) {
    double sum = 0.0;
    for (const auto& triangle : mesh.triangles)
        sum +=
            static_cast<double>((mesh.vertices[triangle[1]] - mesh.vertices[triangle[0]]).norm());
    return mesh.triangles.empty() ? 0.0 : sum / static_cast<double>(mesh.triangles.size());
}

std::vector<float> vertex_spacing_m(const types::Mesh& mesh) {
    std::vector<float> spacing_m(mesh.vertices.size(), 0.0F);
    std::vector<float> areas_m2(mesh.vertices.size(), 0.0F);
    for (const auto& triangle : mesh.triangles) {
        const auto area_m2 = static_cast<float>(types::triangle_area_m2(mesh, triangle));
        for (const std::uint32_t vertex : triangle) {
            spacing_m[vertex] += area_m2 * std::sqrt(2.0F * area_m2);
            areas_m2[vertex] += area_m2;
        }
    }
    for (std::size_t i = 0; i < spacing_m.size(); ++i)
        if (areas_m2[i] > 0.0F) spacing_m[i] /= areas_m2[i];
    return spacing_m;
}

}  // namespace divemesh::mesh
