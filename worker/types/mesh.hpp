#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace divemesh::types {

using Color = std::array<std::uint8_t, 3>;  // r g b

// A triangle mesh in the world frame, m. Vertices are shared between triangles (welded). Triangles
// wind counter-clockwise seen from outside, where the cameras were.
struct Mesh {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3f> normals;  // unit, outward; one per vertex, or empty
    std::vector<Color> colors;             // one per vertex, or empty
    std::vector<float> sigma_m;            // standard deviation along the normal, or empty
    // Its part that only near neighbours share, or empty.
    std::vector<float> sigma_local_m;
    std::vector<std::uint32_t> num_observations;  // views that saw the vertex, or empty
    std::vector<float> voxel_m;  // step of the lattice that the vertex was sampled on, or empty
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace divemesh::types
