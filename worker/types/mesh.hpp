#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace divemesh::types {

using Color = std::array<std::uint8_t, 3>;  // r g b

// A triangle surface in the world frame, m. Vertices are shared between triangles (welded);
// triangles wind counter-clockwise seen from outside, where the cameras were.
struct Mesh {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3f> normals;         // unit, outward; as many as vertices, or none
    std::vector<Color> colors;                    // as many as vertices, or none
    std::vector<float> sigma_m;                   // standard deviation along the normal, or none
    std::vector<float> sigma_local_m;             // of it, what only near neighbours share, or none
    std::vector<std::uint32_t> num_observations;  // views that saw the vertex, or none
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace divemesh::types
