#pragma once

#include <array>
#include <cstdint>

#include "worker/volume/block_coordinate.hpp"

namespace divemesh::worker {

// Samples of 8 x 8 x 8 lattice points, x running fastest.
struct TsdfBlock {
    std::array<float, kBlockSamples> distance_m{};
    std::array<float, kBlockSamples> weight{};             // sum of 1 / variance, 1/m^2
    std::array<std::uint16_t, kBlockSamples> num_views{};  // that saw the surface near the sample
    // Red, green, blue in 1/256 grey values; 0: none.
    std::array<std::array<std::uint16_t, kBlockSamples>, 3> color{};
};

}  // namespace divemesh::worker
