#include "worker/mesh/cut_by_sigma.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "worker/mesh/mesh_components.hpp"

namespace divemesh::mesh {

types::Mesh cut_by_sigma(types::Mesh mesh, double max_sigma_m) {
    if (mesh.sigma_m.empty()) return mesh;
    const auto is_vague = [&](std::uint32_t vertex) {
        return static_cast<double>(mesh.sigma_m[vertex]) > max_sigma_m;
    };
    std::erase_if(mesh.triangles, [&](const auto& triangle) {
        return std::any_of(triangle.begin(), triangle.end(), is_vague);
    });
    remove_unreferenced_vertices(mesh);
    return mesh;
}

}  // namespace divemesh::mesh
