#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Consecutive triangles, which lie close to each other, with a sphere around them.
struct TriangleRun {
    std::size_t begin = 0;
    std::size_t end = 0;
    Eigen::Vector3f center_world;
    float radius_m = 0.0F;
};

// Returns the triangles in runs of at most 1024, in their order.
std::vector<TriangleRun> triangle_runs(const types::Mesh& mesh);

}  // namespace divemesh::mesh
