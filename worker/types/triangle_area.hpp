#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "worker/types/mesh.hpp"

namespace divemesh::types {

// Returns the area of a triangle of the mesh.
inline double triangle_area_m2(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
    const Eigen::Vector3d a = mesh.vertices[triangle[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[triangle[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[triangle[2]].cast<double>();
    return 0.5 * (b - a).cross(c - a).norm();
}

}  // namespace divemesh::types
