#include "worker/fusion/update_block.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <set>

#include "tests/worker/fusion/synthetic_views.hpp"
#include "worker/fusion/packed_values.hpp"
#include "worker/fusion/visible_blocks.hpp"

namespace divemesh::fusion {
namespace {

constexpr float kVoxel_m = 0.02F;

// Returns the signed distance of a tilted wall with a ball in front of it, seen from the world's
// origin along z.
double wall_and_ball(const Eigen::Vector3d& p) {
    const double wall = Eigen::Vector3d(0.3, -0.2, -1.0).normalized().dot(p) + 1.6;
    return std::min(wall, (p - Eigen::Vector3d(0.1, 0.1, 1.0)).norm() - 0.2);
}

class OneView : public testing::Test {
protected:
    OneView()
        : rendered_(render_view(wall_and_ball, small_rig(), Eigen::Isometry3d::Identity(), {}, 1)),
          depth_(small_rig(), rendered_.images),
          view_(view_of(depth_)),
          ranges_(view_) {}

    static TsdfView view_of(const DepthView& depth) {
        const types::RectifiedRig rig = small_rig();
        TsdfView view;
        view.pixels = depth.pixels();
        view.width_px = rig.width_px;
        view.height_px = rig.height_px;
        view.focal_px = static_cast<float>(rig.focal_px);
        view.cx_px = static_cast<float>(rig.cx_px);
        view.cy_px = static_cast<float>(rig.cy_px);
        view.R_cam_world.setIdentity();
        view.t_cam_world.setZero();
        view.voxel_m = kVoxel_m;
        view.max_depth_m = 4.0F;
        view.max_sigma_m = 4.0F * kVoxel_m;
        view.depth_sigma_scale = static_cast<float>(1.0 / (rig.focal_px * rig.baseline_m));
        return view;
    }

    // Returns a block with random values, as earlier views may have left it.
    static TsdfBlock used_block(unsigned seed) {
        std::mt19937 random(seed);
        TsdfBlock block;
        for (int i = 0; i < kBlockSamples; ++i) {
            block.distance[i] = static_cast<std::int16_t>(random() % 6000 - 3000);
            block.weight[i] =
                random() % 3 == 0 ? 0 : pack_weight(1.0F + static_cast<float>(random() % 1000));
            block.views[i] = static_cast<std::uint16_t>(random() % 4);
            block.color[i] = static_cast<std::uint32_t>(random());
        }
        return block;
    }
    template <typename Visit>
    static void for_each_block(Visit&& visit) {
        for (int z = -3; z < 30; ++z)
            for (int y = -14; y < 14; ++y)
                for (int x = -14; x < 14; ++x) visit(BlockCoordinate{x, y, z});
    }
    static bool same(const TsdfBlock& a, const TsdfBlock& b) {
        return std::memcmp(&a, &b, sizeof a) == 0;
    }

    SyntheticView rendered_;
    DepthView depth_;
    TsdfView view_;
    DepthRanges ranges_;
};

TEST_F(OneView, EveryInstructionSetGivesTheSameBytes) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    const DepthView plain(
        small_rig(), rendered_.images, Sampling::Full, base::Instructions::Baseline);
    ASSERT_EQ(std::memcmp(plain.pixels(),
                          depth_.pixels(),
                          sizeof(SurfacePixel) * depth_.rig().width_px * depth_.rig().height_px),
              0);
    const DepthRanges plain_ranges(view_, base::Instructions::Baseline);
    const std::size_t num_pixels = static_cast<std::size_t>(view_.width_px) * view_.height_px;
    ASSERT_EQ(
        std::memcmp(plain_ranges.farthest_m(), ranges_.farthest_m(), sizeof(float) * num_pixels),
        0);
    for (int row = 0; row < ranges_.num_rows(0); ++row)
        for (int column = 0; column < ranges_.num_columns(0); ++column) {
            const DepthRange& range = ranges_.around(0, column, row);
            EXPECT_EQ(plain_ranges.around(0, column, row).nearest_m, range.nearest_m);
            EXPECT_EQ(plain_ranges.around(0, column, row).farthest_m, range.farthest_m);
        }
    int num_changed = 0;
    for_each_block([&](const BlockCoordinate& at) {
        const TsdfBlock before = used_block(static_cast<unsigned>(at.x + 31 * at.y + 997 * at.z));
        TsdfBlock a = before;
        TsdfBlock b = before;
        const BlockPlace place = at.z % 2 == 0 ? BlockPlace::Near : BlockPlace::Before;
        update_block(view_, ranges_, first_sample(at), place, a, base::Instructions::Baseline);
        update_block(view_, ranges_, first_sample(at), place, b);
        ASSERT_TRUE(same(a, b)) << at.x << " " << at.y << " " << at.z;
        num_changed += same(a, before) ? 0 : 1;
    });
    EXPECT_GT(num_changed, 500);
}

TEST_F(OneView, RowsThatAreLeftOutWouldNotHaveChanged) {
    TsdfView coarse = view_;
    coarse.voxel_m *= 100.0F;  // its ranges cover the whole scene
    const DepthRanges everything(coarse);
    int num_changed = 0;
    for_each_block([&](const BlockCoordinate& at) {
        TsdfBlock with;
        TsdfBlock without;
        update_block(view_, ranges_, first_sample(at), BlockPlace::Near, with);
        update_block(view_, everything, first_sample(at), BlockPlace::Near, without);
        ASSERT_TRUE(same(with, without)) << at.x << " " << at.y << " " << at.z;
        num_changed += same(with, TsdfBlock{}) ? 0 : 1;
    });
    EXPECT_GT(num_changed, 200);
}

TEST_F(OneView, WhatIsNotVisibleWouldNotHaveChanged) {
    BlockRegions regions;
    std::vector<BlockCoordinate> blocks;
    for_each_block([&](const BlockCoordinate& at) {
        regions.add(at, static_cast<std::uint32_t>(blocks.size()));
        blocks.push_back(at);
    });
    const auto found = regions.find(VisibleSpace(view_, ranges_), kVoxel_m);
    std::set<std::uint32_t> visible;
    for (const VisibleBlock& block : found) visible.insert(block.number);
    EXPECT_EQ(visible.size(), found.size());
    EXPECT_LT(visible.size(), blocks.size() / 2);
    for (std::uint32_t i = 0; i < blocks.size(); ++i) {
        if (visible.contains(i)) continue;
        const TsdfBlock before = used_block(i);
        TsdfBlock after = before;
        update_block(view_, ranges_, first_sample(blocks[i]), BlockPlace::Near, after);
        EXPECT_TRUE(same(before, after)) << blocks[i].x << " " << blocks[i].y << " " << blocks[i].z;
    }
}

TEST_F(OneView, ABlockBeforeEverySurfaceIsOnlyCarved) {
    BlockRegions regions;
    std::vector<BlockCoordinate> blocks;
    for_each_block([&](const BlockCoordinate& at) {
        regions.add(at, static_cast<std::uint32_t>(blocks.size()));
        blocks.push_back(at);
    });
    int num_before = 0;
    for (const VisibleBlock& seen : regions.find(VisibleSpace(view_, ranges_), kVoxel_m)) {
        if (seen.place != BlockPlace::Before) continue;
        ++num_before;
        TsdfBlock fresh;
        update_block(view_, ranges_, first_sample(blocks[seen.number]), BlockPlace::Near, fresh);
        ASSERT_TRUE(same(fresh, TsdfBlock{}));
        const TsdfBlock before = used_block(seen.number);
        TsdfBlock after = before;
        update_block(view_, ranges_, first_sample(blocks[seen.number]), seen.place, after);
        for (int i = 0; i < kBlockSamples; ++i) {
            ASSERT_GE(after.distance[i], before.distance[i]);
            ASSERT_EQ(after.num_views(i), before.num_views(i));
        }
    }
    EXPECT_GT(num_before, 100);
}

}  // namespace
}  // namespace divemesh::fusion
