#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "worker/base/binary_file.hpp"
#include "worker/fusion/block_coordinate.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::fusion {

// How finely space is sampled, place by place: a balanced octree whose leaves are blocks.
class LevelPlan {
public:
    // Level 0 everywhere.
    LevelPlan() = default;

    int num_levels() const { return num_levels_; }
    int median_level() const { return median_level_; }  // of surface at the dive's median depth

    // Returns the block that holds a lattice point of level 0.
    BlockCoordinate block_at(const Eigen::Vector3i& sample) const {
        for (int level = num_levels_ - 1; level > 0; --level) {
            const int shift = kBlockShift + level;
            const BlockCoordinate block{
                sample.x() >> shift, sample.y() >> shift, sample.z() >> shift, level};
            if (!split_.contains(block)) return block;
        }
        return block_of(sample);
    }

    // Returns the coarsest plan of so many levels in which each of `blocks` and its neighbours is a
    // block or divided further, and in which the levels of blocks that touch differ by one at most.
    static LevelPlan with(const std::vector<BlockCoordinate>& blocks,
                          int num_levels,
                          int median_level);

    void save(base::BinaryWriter& file) const;
    static LevelPlan load(base::BinaryReader& file);

private:
    static constexpr int kBlockShift = 3;

    int num_levels_ = 1;
    int median_level_ = 0;
    std::unordered_set<BlockCoordinate, BlockCoordinateHash> split_;  // divided in eight
};

// Plans levels from what a dive's frames saw: a place is sampled as finely as the second-nearest
// frame that saw it allows. One frame alone, which may show a fish, refines it no further than the
// voxel of the median depth.
class LevelPlanner {
public:
    // `voxel_m` suits surface at `median_depth_m`.
    LevelPlanner(const types::RectifiedRig& rig, double voxel_m, double median_depth_m);

    // Adds a frame by every step_px-th disparity of every step_px-th row (CV_32F, px; <= 0:
    // unknown).
    void add(const Eigen::Isometry3d& T_world_cam, const cv::Mat& disparity_px, int step_px);

    struct Planned {
        LevelPlan plan;
        double voxel_m;  // of level 0
    };
    Planned finish() const;

private:
    // The frames that saw a block from near enough for its level.
    struct Frames {
        int last = 0;
        bool several = false;

        void add(const Frames& other) {
            several = several || other.several || other.last != last;
            last = other.last;
        }
    };
    using Seen = std::unordered_map<BlockCoordinate, Frames, BlockCoordinateHash>;

    Seen with_parents() const;

    types::RectifiedRig rig_;
    double voxel_m_;
    double median_depth_m_;
    double farthest_m_;  // farther depths make no surface at any level
    int num_frames_ = 0;
    int coarsest_ = 0;
    Seen seen_;  // by relative levels
};

}  // namespace divemesh::fusion
