#include "worker/fusion/level_plan.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <set>

#include "tests/temporary_folder.hpp"
#include "worker/fusion/voxel_size.hpp"

namespace divemesh::fusion {
namespace {

constexpr double kVoxel_m = 0.01;
constexpr double kMedianDepth_m = 2.0;

types::RectifiedRig rig() {
    types::RectifiedRig rig;
    rig.width_px = 160;
    rig.height_px = 120;
    rig.focal_px = 500.0;
    rig.cx_px = 79.5;
    rig.cy_px = 59.5;
    rig.baseline_m = 0.12;
    return rig;
}

Eigen::Isometry3d camera_at(double x_m) {
    return Eigen::Isometry3d(Eigen::Translation3d(x_m, 0.0, 0.0));
}

// A wall at one depth fills the image.
cv::Mat wall(double depth_m, int step_px) {
    return cv::Mat(rig().height_px / step_px,
                   rig().width_px / step_px,
                   CV_32F,
                   cv::Scalar(rig().disparity_px(depth_m)));
}

Eigen::Vector3i sample_at(const Eigen::Vector3d& p_world, double voxel_m) {
    return (p_world / voxel_m).array().round().matrix().cast<int>();
}

// The blocks around a box of samples of level 0, each once.
std::set<BlockCoordinate> blocks_in(const LevelPlan& plan, const Eigen::Vector3i& from, int edge) {
    std::set<BlockCoordinate> blocks;
    for (int z = 0; z < edge; z += kBlockEdge)
        for (int y = 0; y < edge; y += kBlockEdge)
            for (int x = 0; x < edge; x += kBlockEdge)
                blocks.insert(plan.block_at(from + Eigen::Vector3i(x, y, z)));
    return blocks;
}

// First and last sample of level 0 of a block.
std::pair<Eigen::Array3i, Eigen::Array3i> extent(const BlockCoordinate& block) {
    const Eigen::Array3i first = first_sample(block).array() * (1 << block.level);
    return {first, first + (kBlockEdge << block.level)};
}

TEST(LevelPlan, IsOneLevelOfBlocksByDefault) {
    const LevelPlan plan;
    EXPECT_EQ(plan.num_levels(), 1);
    EXPECT_EQ(plan.block_at({-1, 8, 15}), (BlockCoordinate{-1, 1, 1, 0}));
}

TEST(LevelPlan, LevelsOfBlocksThatTouchDifferByOneAtMost) {
    std::mt19937 random(4);
    std::uniform_int_distribution<int> place(-40, 40);
    std::vector<BlockCoordinate> wanted;
    for (int i = 0; i < 6; ++i)
        wanted.push_back({place(random), place(random), place(random), i % 2});
    const LevelPlan plan = LevelPlan::with(wanted, 5, 0);
    for (const BlockCoordinate& block : wanted)
        EXPECT_LE(plan.block_at(first_sample(block) * (1 << block.level)).level, block.level);
    const auto blocks = blocks_in(plan, Eigen::Vector3i::Constant(-512), 1024);
    std::set<int> levels;
    for (const BlockCoordinate& block : blocks) levels.insert(block.level);
    EXPECT_EQ(levels, (std::set<int>{0, 1, 2, 3, 4}));
    std::int64_t volume = 0;
    for (const BlockCoordinate& block : blocks) {
        volume += std::int64_t{1} << (3 * block.level);
        const auto [first, end] = extent(block);
        for (int side = 0; side < 27; ++side) {
            const Eigen::Array3i step(side % 3 - 1, side / 3 % 3 - 1, side / 9 - 1);
            const Eigen::Array3i outside =
                (step < 0).select(first - 1, (step > 0).select(end, first + (end - first) / 2));
            EXPECT_LE(std::abs(plan.block_at(outside.matrix()).level - block.level), 1);
        }
    }
    EXPECT_GE(volume, std::int64_t{128} * 128 * 128) << "the blocks fill the box";
}

TEST(LevelPlan, IsTheSameFromItsFile) {
    const TemporaryFolder folder;
    const LevelPlan plan = LevelPlan::with({{3, -4, 5, 0}, {-20, 7, 1, 1}}, 4, 2);
    {
        base::BinaryWriter file(folder / "plan");
        plan.save(file);
        file.commit();
    }
    base::BinaryReader file(folder / "plan");
    const LevelPlan loaded = LevelPlan::load(file);
    ASSERT_TRUE(file.ok() && file.at_end());
    EXPECT_EQ(loaded.num_levels(), 4);
    EXPECT_EQ(loaded.median_level(), 2);
    EXPECT_EQ(blocks_in(loaded, Eigen::Vector3i::Constant(-256), 512),
              blocks_in(plan, Eigen::Vector3i::Constant(-256), 512));
}

TEST(LevelPlanner, SamplesWhatIsAtHalfAndTwiceTheDepthByHalfAndTwiceTheVoxel) {
    LevelPlanner planner(rig(), kVoxel_m, kMedianDepth_m);
    for (const double x_m : {0.0, 0.01}) {
        planner.add(camera_at(x_m), wall(0.9, 8), 8);
        planner.add(camera_at(x_m + 20.0), wall(2.1, 8), 8);
        planner.add(camera_at(x_m + 40.0), wall(3.9, 8), 8);
    }
    const auto [plan, voxel_m] = planner.finish();
    EXPECT_DOUBLE_EQ(voxel_m, 0.5 * kVoxel_m);
    EXPECT_EQ(plan.num_levels(), 3);
    EXPECT_EQ(plan.median_level(), 1);
    EXPECT_EQ(plan.block_at(sample_at({0.0, 0.0, 0.9}, voxel_m)).level, 0);
    EXPECT_EQ(plan.block_at(sample_at({20.0, 0.0, 2.1}, voxel_m)).level, 1);
    EXPECT_EQ(plan.block_at(sample_at({40.0, 0.0, 3.9}, voxel_m)).level, 2);
}

TEST(LevelPlanner, TheNearerViewDecides) {
    LevelPlanner planner(rig(), kVoxel_m, kMedianDepth_m);
    for (int i = 0; i < 20; ++i) planner.add(camera_at(0.01 * i), wall(4.0, 8), 8);
    const Eigen::Isometry3d nearer(Eigen::Translation3d(0.0, 0.0, 3.0));
    for (int i = 0; i < 2; ++i) planner.add(nearer * camera_at(0.01 * i), wall(1.0, 8), 8);
    const auto [plan, voxel_m] = planner.finish();
    EXPECT_EQ(plan.block_at(sample_at({0.0, 0.0, 4.0}, voxel_m)).level, 0);
    EXPECT_EQ(plan.block_at(sample_at({0.45, 0.4, 4.0}, voxel_m)).level, 2)
        << "only seen from afar";
}

TEST(LevelPlanner, WhatOneFrameAloneSawNearRefinesNothing) {
    LevelPlanner planner(rig(), kVoxel_m, kMedianDepth_m);
    for (int i = 0; i < 5; ++i) {
        cv::Mat disparities = wall(2.0, 8);
        if (i == 2) disparities(cv::Rect(4, 4, 3, 3)).setTo(rig().disparity_px(0.4));
        planner.add(camera_at(0.01 * i), disparities, 8);
    }
    const auto [plan, voxel_m] = planner.finish();
    EXPECT_DOUBLE_EQ(voxel_m, kVoxel_m);
    EXPECT_EQ(plan.num_levels(), 1);
}

// A dive that looks at a wall at 8 m, but in one frame at another at 2 m.
TEST(LevelPlanner, WhatOneFrameAloneSawIsSampledAsItSawIt) {
    LevelPlanner planner(rig(), kVoxel_m, kMedianDepth_m);
    for (int i = 0; i < 5; ++i) planner.add(camera_at(0.01 * i), wall(8.0, 8), 8);
    planner.add(camera_at(20.0), wall(2.0, 8), 8);
    const auto [plan, voxel_m] = planner.finish();
    EXPECT_DOUBLE_EQ(voxel_m, kVoxel_m);
    EXPECT_GE(plan.num_levels(), 3);
    EXPECT_EQ(plan.block_at(sample_at({20.0, 0.0, 2.0}, voxel_m)).level, 0);
    EXPECT_EQ(plan.block_at(sample_at({0.0, 0.0, 8.0}, voxel_m)).level, plan.num_levels() - 1);
}

TEST(LevelPlanner, AFishInOneFrameOfAFarSceneRefinesNothingBelowTheMedianVoxel) {
    LevelPlanner planner(rig(), kVoxel_m, kMedianDepth_m);
    for (int i = 0; i < 5; ++i) {
        cv::Mat disparities = wall(4.0, 8);
        if (i == 2) disparities(cv::Rect(4, 4, 3, 3)).setTo(rig().disparity_px(0.4));
        planner.add(camera_at(0.01 * i), disparities, 8);
    }
    const auto [plan, voxel_m] = planner.finish();
    EXPECT_DOUBLE_EQ(voxel_m, kVoxel_m);
    EXPECT_EQ(plan.median_level(), 0);
}

TEST(LevelPlanner, ASingleFrameIsEnoughForItself) {
    LevelPlanner planner(rig(), kVoxel_m, kMedianDepth_m);
    planner.add(camera_at(0.0), wall(0.5, 8), 8);
    EXPECT_DOUBLE_EQ(planner.finish().voxel_m, 0.25 * kVoxel_m);
}

}  // namespace
}  // namespace divemesh::fusion
