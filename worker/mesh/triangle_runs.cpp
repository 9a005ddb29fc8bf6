#include "worker/mesh/triangle_runs.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>

namespace divemesh::mesh {

std::vector<TriangleRun> triangle_runs(const types::Mesh& mesh) {
    constexpr std::size_t kMaxTriangles = 1024;
    std::vector<TriangleRun> runs;
    for (std::size_t begin = 0; begin < mesh.triangles.size(); begin += kMaxTriangles) {
        const std::size_t end = std::min(mesh.triangles.size(), begin + kMaxTriangles);
        Eigen::AlignedBox3f box;
        for (std::size_t i = begin; i < end; ++i)
            for (const std::uint32_t vertex : mesh.triangles[i]) box.extend(mesh.vertices[vertex]);
        runs.push_back({begin, end, box.center(), 0.5F * box.diagonal().norm()});
    }
    return runs;
}

}  // namespace divemesh::mesh
