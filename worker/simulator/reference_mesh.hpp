#pragma once

#include <cstdint>
#include <vector>

#include "worker/simulator/scene.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::simulator {

// The part of a scene that was seen, coloured with its reflectance. A triangle that was missed
// although its whole neighbourhood was seen (no ray happened to meet it) belongs to it.
types::Mesh make_reference_mesh(const Scene& scene,
                                const std::vector<bool>& seen,
                                std::uint64_t seed);

}  // namespace divemesh::simulator
