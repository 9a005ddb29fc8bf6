#include "worker/fusion/level_plan.hpp"

#include <algorithm>
#include <cmath>

#include "worker/fusion/voxel_size.hpp"

namespace divemesh::fusion {
namespace {

constexpr double kMinVoxel_m = 0.001;
constexpr double kMaxSample = 1e9;  // of a lattice

}  // namespace

// The neighbours of a divided block are of its level at least, so their parents are divided too.
LevelPlan LevelPlan::with(const std::vector<BlockCoordinate>& blocks,
                          int num_levels,
                          int median_level) {
    LevelPlan plan;
    plan.num_levels_ = num_levels;
    plan.median_level_ = median_level;
    std::vector<std::vector<BlockCoordinate>> divided(static_cast<std::size_t>(num_levels) + 1);
    const auto divide = [&](const BlockCoordinate& block) {
        if (block.level < num_levels && plan.split_.insert(block).second)
            divided[block.level].push_back(block);
    };
    const auto divide_around = [&](const BlockCoordinate& block) {
        for (int n = 0; n < 27; ++n)
            divide((block + BlockCoordinate{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}).parent());
    };
    for (const BlockCoordinate& block : blocks) divide_around(block);
    for (int level = 1; level < num_levels; ++level)
        for (const BlockCoordinate& block : divided[level]) divide_around(block);
    return plan;
}

void LevelPlan::save(base::BinaryWriter& file) const {
    std::vector<BlockCoordinate> divided(split_.begin(), split_.end());
    std::sort(divided.begin(), divided.end());
    file.put(num_levels_);
    file.put(median_level_);
    file.put(static_cast<std::uint64_t>(divided.size()));
    for (const BlockCoordinate& block : divided) file.put(block);
}

LevelPlan LevelPlan::load(base::BinaryReader& file) {
    LevelPlan plan;
    plan.num_levels_ = std::clamp(file.get<int>(), 1, kMaxRelativeLevel - kMinRelativeLevel + 1);
    plan.median_level_ = file.get<int>();
    const auto num_divided = file.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < num_divided && file.ok(); ++i)
        plan.split_.insert(file.get<BlockCoordinate>());
    return plan;
}

LevelPlanner::LevelPlanner(const types::RectifiedRig& rig, double voxel_m, double median_depth_m)
    : rig_(rig),
      voxel_m_(voxel_m),
      median_depth_m_(median_depth_m),
      farthest_m_(farthest_surface_m(rig, median_depth_m)) {}

void LevelPlanner::add(const Eigen::Isometry3d& T_world_cam,
                       const cv::Mat& disparity_px,
                       int step_px) {
    ++num_frames_;
    for (int row = 0; row < disparity_px.rows; ++row)
        for (int column = 0; column < disparity_px.cols; ++column) {
            const float disparity = disparity_px.at<float>(row, column);
            if (disparity <= 0.0F) continue;
            const double depth_m = rig_.depth_m(disparity);
            if (depth_m > farthest_m_) continue;
            const int level = relative_level(rig_, median_depth_m_, depth_m);
            coarsest_ = std::max(coarsest_, level);
            const Eigen::Vector3d p_world =
                T_world_cam * rig_.point_cam(column * step_px, row * step_px, depth_m);
            const Eigen::Vector3d sample = p_world / std::ldexp(voxel_m_, level);
            if (!(sample.cwiseAbs().maxCoeff() < kMaxSample)) continue;
            const BlockCoordinate block =
                block_of(sample.array().round().matrix().cast<int>(), level);
            const Frames frame{num_frames_, false};
            seen_.try_emplace(block, frame).first->second.add(frame);
        }
}

// Adds what is near enough for a level to all coarser ones, for which it is near enough too.
LevelPlanner::Seen LevelPlanner::with_parents() const {
    Seen all = seen_;
    for (int level = kMinRelativeLevel; level < coarsest_; ++level) {
        std::vector<std::pair<BlockCoordinate, Frames>> parents;
        for (const auto& [block, frames] : all)
            if (block.level == level) parents.emplace_back(block.parent(), frames);
        for (const auto& [parent, frames] : parents)
            all.try_emplace(parent, frames).first->second.add(frames);
    }
    return all;
}

LevelPlanner::Planned LevelPlanner::finish() const {
    std::vector<BlockCoordinate> blocks;
    int finest = 0;
    for (const auto& [block, frames] : with_parents()) {
        if (block.level < 0 && !frames.several && num_frames_ > 1) continue;
        if (std::ldexp(voxel_m_, block.level) < kMinVoxel_m) continue;
        finest = std::min(finest, block.level);
        blocks.push_back(block);
    }
    for (BlockCoordinate& block : blocks) block.level -= finest;
    return {LevelPlan::with(blocks, coarsest_ - finest + 1, -finest), std::ldexp(voxel_m_, finest)};
}

}  // namespace divemesh::fusion
