#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "worker/fusion/block_coordinate.hpp"
#include "worker/fusion/update_block.hpp"

namespace divemesh::fusion {

// The space that a view may change: inside its image and no farther behind the surface there than
// the truncation distance.
class VisibleSpace {
public:
    // `view` and `ranges` must outlive this object.
    VisibleSpace(const TsdfView& view, const DepthRanges& ranges);

    // Returns the place of a ball in the world; nullopt if the view changes no part of it.
    std::optional<BlockPlace> place_of(const Eigen::Vector3f& middle, float radius_m) const;
    Eigen::AlignedBox3f bounds() const;  // in the world, m

private:
    DepthRange range_around(const Eigen::Vector3f& p_cam, float radius_m) const;

    const TsdfView& view_;
    const DepthRanges& ranges_;
    float slack_x_;  // how far the image's sides are moved out, per radius
    float slack_y_;
};

// A block that a view may change, by its number in BlockRegions::add().
struct VisibleBlock {
    std::uint32_t number;
    BlockPlace place;
};

// Blocks of one level by position, so that those in a view are found without testing each block.
class BlockRegions {
public:
    void add(const BlockCoordinate& block, std::uint32_t number);
    bool empty() const { return regions_.empty(); }
    // Returns the blocks that may reach into a space, in an order that depends only on that of
    // add().
    std::vector<VisibleBlock> find(const VisibleSpace& space, float voxel_m) const;

private:
    struct Region {  // of 8 x 8 x 8 blocks
        BlockCoordinate coordinate;
        std::vector<BlockCoordinate> blocks;
        std::vector<std::uint32_t> numbers;
    };

    static void find_in(const Region& region,
                        const VisibleSpace& space,
                        float voxel_m,
                        std::vector<VisibleBlock>& found);

    std::vector<Region> regions_;
    std::unordered_map<BlockCoordinate, std::size_t, BlockCoordinateHash> index_;
};

}  // namespace divemesh::fusion
