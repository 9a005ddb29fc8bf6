#pragma once

#include <vector>

#include "worker/fusion/level_plan.hpp"

namespace divemesh::fusion {

// The blocks of a plan that a view has touched recently: most pixels lie in the same blocks as
// their neighbours, and the plan itself is slow to ask.
class RecentBlocks {
public:
    explicit RecentBlocks(const LevelPlan& plan) : plan_(plan) {}

    struct Place {
        BlockCoordinate block{INT32_MAX, 0, 0, 0};
        bool is_allocated = false;
    };
    // Returns the place of the block that holds a lattice point of level 0. It is valid until the
    // next call.
    Place& at(const Eigen::Vector3i& sample) {
        for (int i = 0; i < plan_.num_levels(); ++i) {
            const int level = (last_level_ + i) % plan_.num_levels();
            const BlockCoordinate block =
                block_of(sample.unaryExpr([&](int x) { return x >> level; }), level);
            Place& place = place_of(block);
            if (place.block != block) continue;
            last_level_ = level;
            return place;
        }
        const BlockCoordinate block = plan_.block_at(sample);
        last_level_ = block.level;
        return place_of(block) = {block, false};
    }

private:
    static constexpr std::size_t kNumPlaces = 1024;

    Place& place_of(const BlockCoordinate& block) {
        return places_[BlockCoordinateHash()(block) % kNumPlaces];
    }

    const LevelPlan& plan_;
    int last_level_ = 0;
    std::vector<Place> places_ = std::vector<Place>(kNumPlaces);
};

}  // namespace divemesh::fusion
