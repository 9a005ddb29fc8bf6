#pragma once

#include <cstdint>
#include <vector>

#include "worker/simulator/scene.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::simulator {

// Returns the part of a scene that was seen, coloured with its reflectance. It includes triangles
// that no ray happened to hit although their whole neighbourhood was seen.
types::Mesh make_reference_mesh(const Scene& scene,
                                const std::vector<bool>& seen,
                                std::uint64_t seed);

}  // namespace divemesh::simulator
