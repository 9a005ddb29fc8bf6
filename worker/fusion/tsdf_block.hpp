#pragma once

#include <array>
#include <cstdint>

#include "worker/fusion/block_coordinate.hpp"

namespace divemesh::fusion {

// Distances are kept to this part of a voxel, up to 16 voxels.
inline constexpr float kDistanceSteps = 2048.0F;

// Samples of 8 x 8 x 8 lattice points, x running fastest, 10 bytes each; packed as
// worker/fusion/packed_values.hpp says.
struct TsdfBlock {
    std::array<std::int16_t, kBlockSamples> distance{};    // 1 / kDistanceSteps voxels
    std::array<std::uint16_t, kBlockSamples> weight{};     // sum of 1 / variance
    std::array<std::uint16_t, kBlockSamples> num_views{};  // that saw the surface near the sample
    std::array<std::uint32_t, kBlockSamples> color{};      // red, green, blue; 0: none
};
static_assert(sizeof(TsdfBlock) == 10 * kBlockSamples);

}  // namespace divemesh::fusion
