#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "worker/fusion/block_coordinate.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::fusion {

inline constexpr float kUnknownDistance = std::numeric_limits<float>::quiet_NaN();

// The attributes of a sample besides its distance.
struct SampleAttributes {
    types::Color color = {0, 0, 0};
    bool has_color = false;
    float sigma_m = 0.0F;  // standard deviation of the distance
    std::uint32_t num_observations = 0;
};

// A sparse signed distance to the surface: positive on the side of the cameras, unknown away from
// the surface and where too little was seen. It is the interface of both volumes to both meshers.
// Blocks are disjoint, and the levels of two that touch differ by one at most (a balanced octree).
// Thread-safe, except for release_memory().
class SignedDistanceField {
public:
    virtual ~SignedDistanceField() = default;

    virtual double voxel_m() const = 0;  // step of the lattice of level 0, the finest
    virtual const std::vector<BlockCoordinate>& blocks() const = 0;  // sorted
    // Writes the 512 distances of a block, m; kUnknownDistance where unknown.
    virtual void read_distances(std::size_t block, float* distances_m) const = 0;
    virtual float distance_m(std::size_t block, int sample) const = 0;
    virtual SampleAttributes attributes(std::size_t block, int sample) const = 0;
    // Spills what was read. Call it now and then on a walk through the field, so that the field
    // need not fit into memory.
    virtual void release_memory() const {}
};

}  // namespace divemesh::fusion
