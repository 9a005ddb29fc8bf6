#include "worker/fusion/point_octree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/temporary_folder.hpp"
#include "worker/fusion/packed_values.hpp"

namespace divemesh::fusion {
namespace {

PointObservation observe(const Eigen::Vector3d& p_world, float weight = 1.0F, int view = 0) {
    PointObservation observation;
    observation.p_world = p_world;
    observation.normal = Eigen::Vector3f::UnitZ();
    observation.color = {200, 100, 50};
    observation.weight = weight;
    observation.view = static_cast<std::uint8_t>(view);
    return observation;
}

TEST(PointOctree, KeepsTheWeightedMeanOfALeaf) {
    PointOctree octree(0.01);
    octree.insert(observe({0.001, -0.002, 0.003}, 1.0F));
    octree.insert(observe({0.005, -0.006, 0.007}, 3.0F));
    ASSERT_EQ(octree.num_points(), 1);
    const PointLeaf* leaf = octree.find({0, -1, 0});
    ASSERT_NE(leaf, nullptr);
    const Eigen::Vector3d mean = octree.position({0, -1, 0}, *leaf);
    EXPECT_LT((mean - Eigen::Vector3d(0.004, -0.005, 0.006)).norm(), 1e-5);
    EXPECT_EQ(leaf_color(*leaf), (types::Color{200, 100, 50}));
    EXPECT_NEAR(leaf_normal(*leaf).z(), 1.0F, 1e-3F);
    EXPECT_FLOAT_EQ(unpack_weight(leaf->weight), 4.0F);
}

TEST(PointOctree, CountsViewsNotPoints) {
    PointOctree octree(0.01);
    for (int view = 0; view < 3; ++view)
        for (int i = 0; i < 5; ++i) octree.insert(observe({0.001 * i, 0.0, 0.0}, 1.0F, view));
    EXPECT_EQ(octree.find({0, 0, 0})->num_views, 3);
}

TEST(PointOctree, FindsEveryLeafOfARandomCloudAndNoOther) {
    PointOctree octree(0.05);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-20.0, 20.0);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 5000; ++i) {
        points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
        ASSERT_TRUE(octree.insert(observe(points.back())));
    }
    for (const auto& point : points)
        EXPECT_NE(octree.find((point / 0.05).array().floor().cast<int>()), nullptr);
    EXPECT_EQ(octree.find({100000, 0, 0}), nullptr);
    std::int64_t visited = 0;
    octree.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        ++visited;
        EXPECT_EQ(octree.find(cell), &leaf);
    });
    EXPECT_EQ(visited, octree.num_points());
}

TEST(PointOctree, VisitsBlocksOfEightLeavesASideOneAfterTheOther) {
    PointOctree octree(1.0);
    for (int i = 0; i < 4000; ++i)
        octree.insert(observe({(i * 7) % 40 - 20.0, (i * 13) % 40 - 20.0, (i * 29) % 24 - 12.0}));
    std::vector<Eigen::Vector3i> blocks;
    octree.for_each([&](const Eigen::Vector3i& cell, const PointLeaf&) {
        const Eigen::Vector3i block(cell.x() >> 3, cell.y() >> 3, cell.z() >> 3);
        if (!blocks.empty() && blocks.back() == block) return;
        EXPECT_EQ(std::find(blocks.begin(), blocks.end(), block), blocks.end());
        blocks.push_back(block);
    });
    EXPECT_GT(blocks.size(), 20U);
}

// Inserts a rough bed with leaves about as far apart as the points, as a dive produces it.
void insert_bed(PointOctree& octree, int side, double spacing_m) {
    std::mt19937 random(1);
    std::normal_distribution<double> height(0.0, 1.5 * octree.leaf_m());
    for (int view = 0; view < 4; ++view)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                octree.insert(observe({spacing_m * x, spacing_m * y, height(random)}, 1.0F, view));
}

TEST(PointOctree, APointOnASurfaceTakesNoMoreThan24BytesHoweverFarApartPointsAre) {
    for (const double spacing_leaves : {0.5, 1.0, 1.5, 2.0, 2.5}) {
        PointOctree octree(0.004);
        const auto side = static_cast<int>(600.0 / std::sqrt(spacing_leaves));
        insert_bed(octree, side, spacing_leaves * octree.leaf_m());
        ASSERT_GT(octree.num_points(), 300000);
        const double bytes_per_point =
            static_cast<double>(octree.size_bytes()) / static_cast<double>(octree.num_points());
        RecordProperty("bytes_per_point_" + std::to_string(spacing_leaves),
                       std::to_string(bytes_per_point));
        EXPECT_LT(bytes_per_point, 24.0) << spacing_leaves;
    }
}

TEST(PointOctree, IsTheSameWhenMostOfItIsOnDisk) {
    const TemporaryFolder folder;
    PointOctree small(0.004, {folder / "", std::int64_t{4} << 20});
    PointOctree whole(0.004);
    for (PointOctree* octree : {&small, &whole})
        for (int part = 0; part < 6; ++part) {
            insert_bed(*octree, 150 + 50 * part, 0.004);
            octree->trim();
        }
    ASSERT_EQ(small.num_points(), whole.num_points());
    EXPECT_LT(small.memory_bytes(), small.size_bytes() / 2);
    std::vector<PointLeaf> expected;
    whole.for_each(
        [&](const Eigen::Vector3i&, const PointLeaf& leaf) { expected.push_back(leaf); });
    std::size_t i = 0;
    std::size_t num_different = 0;
    small.for_each([&](const Eigen::Vector3i&, const PointLeaf& leaf) {
        num_different += std::memcmp(&leaf, &expected[i++], sizeof leaf) != 0 ? 1 : 0;
    });
    EXPECT_EQ(num_different, 0U);
}

TEST(PointOctree, RefusesWhatIsNotFiniteOrTooFar) {
    PointOctree octree(0.01);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(octree.insert(observe({nan, 0.0, 0.0})));
    EXPECT_FALSE(octree.insert(observe({0.0, 1e12, 0.0})));
    EXPECT_EQ(octree.num_points(), 0);
}

TEST(PointOctree, RepeatedObservationsTakeNoMemory) {
    PointOctree octree(0.01);
    for (int i = 0; i < 1000; ++i) octree.insert(observe({0.01 * (i % 100), 0.0, 0.0}));
    const auto before = octree.memory_bytes();
    for (int i = 0; i < 200000; ++i) octree.insert(observe({0.01 * (i % 100), 0.0, 0.0}));
    EXPECT_EQ(octree.memory_bytes(), before);
}

}  // namespace
}  // namespace divemesh::fusion
