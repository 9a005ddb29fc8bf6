#pragma once

#include <array>
#include <cstdint>

#include "worker/fusion/block_coordinate.hpp"

namespace divemesh::fusion {

// Distances are stored in steps of 1 / kDistanceSteps voxels, up to 16 voxels.
inline constexpr float kDistanceSteps = 2048.0F;

// Samples of 8 x 8 x 8 lattice points, x running fastest, 10 bytes each; packed as described in
// worker/fusion/packed_values.hpp.
struct TsdfBlock {
    std::array<std::int16_t, kBlockSamples> distance{};  // in 1 / kDistanceSteps voxels
    std::array<std::uint16_t, kBlockSamples> weight{};   // sum of 1 / variance
    // Views that saw the surface near the sample, up to kMaxViews, and kUnshared.
    std::array<std::uint16_t, kBlockSamples> views{};
    std::array<std::uint32_t, kBlockSamples> color{};  // red, green, blue; 0: no colour

    static constexpr std::uint16_t kMaxViews = 0x7fff;
    static constexpr std::uint16_t kUnshared = 0x8000;  // one view saw it where no other looked
    std::uint32_t num_views(int sample) const { return views[sample] & kMaxViews; }
    bool is_unshared(int sample) const { return (views[sample] & kUnshared) != 0; }
};
static_assert(sizeof(TsdfBlock) == std::size_t{10} * kBlockSamples);

}  // namespace divemesh::fusion
