#pragma once

#include <cstdint>

#include "worker/types/mesh.hpp"

namespace divemesh::texture {

// Adds a square in the plane of a height, seen from above (+z), in num x num cells of two triangles
// each, row by row.
inline void add_square(types::Mesh& mesh,
                       const Eigen::Vector3f& center,
                       float side_m,
                       std::uint32_t num) {
    const float cell_m = side_m / static_cast<float>(num);
    const Eigen::Vector3f corner = center - 0.5F * Eigen::Vector3f(side_m, side_m, 0.0F);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t row = 0; row <= num; ++row)
        for (std::uint32_t column = 0; column <= num; ++column)
            mesh.vertices.push_back(corner + cell_m * Eigen::Vector3f(static_cast<float>(column),
                                                                      static_cast<float>(row),
                                                                      0.0F));
    for (std::uint32_t row = 0; row < num; ++row)
        for (std::uint32_t column = 0; column < num; ++column) {
            const std::uint32_t a = first + row * (num + 1) + column;
            const std::uint32_t b = a + num + 1;
            mesh.triangles.push_back({a, a + 1, b + 1});
            mesh.triangles.push_back({a, b + 1, b});
        }
}

inline types::Mesh square_mesh(float side_m, std::uint32_t num) {
    types::Mesh mesh;
    add_square(mesh, Eigen::Vector3f::Zero(), side_m, num);
    return mesh;
}

inline Eigen::Vector3f center_of(const types::Mesh& mesh, std::size_t face) {
    const auto& [a, b, c] = mesh.triangles[face];
    return (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3.0F;
}

}  // namespace divemesh::texture
