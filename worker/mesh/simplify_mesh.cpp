#include "worker/mesh/simplify_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <meshoptimizer.h>

#include "worker/mesh/mesh_components.hpp"

namespace divemesh::mesh {

types::Mesh simplify_mesh(const types::Mesh& mesh, const SimplifyLimits& limits) {
    if (mesh.triangles.empty()) return mesh;
    const float* positions = mesh.vertices.front().data();
    constexpr std::size_t kStride = sizeof(Eigen::Vector3f);
    static_assert(sizeof(mesh.triangles.front()) == 3 * sizeof(unsigned));
    const unsigned* indices = mesh.triangles.front().data();
    const std::size_t num_indices = 3 * mesh.triangles.size();
    const auto target = 3 * static_cast<std::size_t>(std::ceil(
                                limits.share * static_cast<double>(mesh.triangles.size())));
    // Errors are relative to the mesh's extent; 1 means no limit.
    const float extent_m = meshopt_simplifyScale(positions, mesh.vertices.size(), kStride);
    const float max_error =
        limits.max_error_m > 0.0 ? static_cast<float>(limits.max_error_m) / extent_m : 1.0F;
    types::Mesh simplified = mesh;
    const std::size_t num_left = meshopt_simplify(simplified.triangles.front().data(),
                                                  indices,
                                                  num_indices,
                                                  positions,
                                                  mesh.vertices.size(),
                                                  kStride,
                                                  target,
                                                  max_error,
                                                  0,
                                                  nullptr);
    simplified.triangles.resize(num_left / 3);
    remove_unreferenced_vertices(simplified);
    return simplified;
}

}  // namespace divemesh::mesh
