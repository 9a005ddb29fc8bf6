#include "worker/mesh/mean_edge.hpp"

namespace divemesh::mesh {

double mean_edge_m(const types::Mesh& mesh) {
    double sum = 0.0;
    for (const auto& triangle : mesh.triangles)
        sum +=
            static_cast<double>((mesh.vertices[triangle[1]] - mesh.vertices[triangle[0]]).norm());
    return mesh.triangles.empty() ? 0.0 : sum / static_cast<double>(mesh.triangles.size());
}

}  // namespace divemesh::mesh
