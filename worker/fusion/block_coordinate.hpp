#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstddef>
#include <cstdint>

namespace divemesh::fusion {

// Space is sampled on lattices through the world's origin. At level l sample (i, j, k) lies at
// 2^l * voxel_m * (i, j, k), so a lattice contains the samples of all coarser ones. Samples are kept
// in blocks of 8 x 8 x 8; a block is as large as 2 x 2 x 2 blocks of the level below.
inline constexpr int kBlockEdge = 8;
inline constexpr int kBlockSamples = kBlockEdge * kBlockEdge * kBlockEdge;

// Index of a block: its first sample is lattice point 8 * (x, y, z) of its level.
struct BlockCoordinate {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    std::int32_t level = 0;

    // NOLINTNEXTLINE(modernize-use-nullptr): a false positive of clang-tidy 14
    auto operator<=>(const BlockCoordinate&) const = default;
    // Returns the block of the same level that lies `offset` blocks further.
    BlockCoordinate operator+(const BlockCoordinate& offset) const {
        return {x + offset.x, y + offset.y, z + offset.z, level};
    }
    // Returns the block of the next coarser level that this one is a part of.
    BlockCoordinate parent() const { return {x >> 1, y >> 1, z >> 1, level + 1}; }
};

struct BlockCoordinateHash {
    std::size_t operator()(const BlockCoordinate& block) const {
        auto h =
            static_cast<std::uint64_t>(static_cast<std::uint32_t>(block.x)) * 0x9E3779B97F4A7C15ULL;
        h ^=
            static_cast<std::uint64_t>(static_cast<std::uint32_t>(block.y)) * 0xC2B2AE3D27D4EB4FULL;
        h ^=
            static_cast<std::uint64_t>(static_cast<std::uint32_t>(block.z)) * 0x165667B19E3779F9ULL;
        h += static_cast<std::uint64_t>(static_cast<std::uint32_t>(block.level)) *
             0x2545F4914F6CDD1DULL;
        h ^= h >> 32;
        return static_cast<std::size_t>(h * 0xD6E8FEB86659FD93ULL);
    }
};

// Returns the index of a sample in its block, x running fastest; coordinates are 0 to 7.
inline int sample_index(int x, int y, int z) { return (z * kBlockEdge + y) * kBlockEdge + x; }

// Return the block of a level's lattice point and the point's index in it. The arithmetic shift
// handles negative coordinates too.
inline BlockCoordinate block_of(const Eigen::Vector3i& sample, int level = 0) {
    return {sample.x() >> 3, sample.y() >> 3, sample.z() >> 3, level};
}
inline int index_in_block(const Eigen::Vector3i& sample) {
    return sample_index(sample.x() & 7, sample.y() & 7, sample.z() & 7);
}

// Returns the lattice point of a block's first sample.
inline Eigen::Vector3i first_sample(const BlockCoordinate& block) {
    return Eigen::Vector3i(block.x, block.y, block.z) * kBlockEdge;
}

}  // namespace divemesh::fusion
