#include "worker/io/thin_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace divemesh::io {
namespace {

TEST(ThinPointsTest, FewPointsAreAllKept) {
    const std::vector<Eigen::Vector3f> points(5, Eigen::Vector3f::Ones());

    EXPECT_EQ(thin_points(points, 5), (std::vector<std::size_t>{0, 1, 2, 3, 4}));
    EXPECT_TRUE(thin_points({}, 5).empty());
}

TEST(ThinPointsTest, PointsAtOnePlaceBecomeOne) {
    EXPECT_EQ(thin_points(std::vector<Eigen::Vector3f>(9, Eigen::Vector3f::Ones()), 5).size(), 1U);
}

// A square of 2 m whose left half was measured four times as densely.
std::vector<Eigen::Vector3f> uneven_square() {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 400; ++i)
        for (int j = 0; j < 800; ++j) {
            const float step_m = 0.0025F;
            if (i % 2 == 0 && j % 2 == 0)
                points.emplace_back(
                    1.0F + step_m * static_cast<float>(i), step_m * static_cast<float>(j), 0.5F);
            points.emplace_back(
                step_m * static_cast<float>(i), step_m * static_cast<float>(j), 0.5F);
        }
    return points;
}

TEST(ThinPointsTest, DenseAndSparsePartsKeepTheSameDensity) {
    const std::vector<Eigen::Vector3f> points = uneven_square();
    constexpr std::size_t kWanted = 10'000;

    const auto kept = thin_points(points, kWanted);

    EXPECT_EQ(kept.size(), kWanted);
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    std::map<std::pair<int, int>, int> num_in_tile;  // of 20 cm: 100 each
    for (const std::size_t i : kept)
        ++num_in_tile[{static_cast<int>(points[i].x() * 5.0F),
                       static_cast<int>(points[i].y() * 5.0F)}];
    ASSERT_EQ(num_in_tile.size(), 100U);
    for (const auto& [tile, number] : num_in_tile) EXPECT_NEAR(number, 100, 30);
}

TEST(ThinPointsTest, EachIndexComesOnce) {
    const auto kept = thin_points(uneven_square(), 12'345);

    EXPECT_EQ(std::set<std::size_t>(kept.begin(), kept.end()).size(), kept.size());
}

TEST(ThinPointsTest, TakesCoordinatesOfAnySize) {
    const std::vector<Eigen::Vector3f> points = {
        {-3e38F, 0, 0}, {3e38F, 0, 0}, {0, 3e38F, 0}, {1e-38F, 0, 0}, {0, 0, -3e38F}};

    EXPECT_EQ(thin_points(points, 2).size(), 2U);
}

}  // namespace
}  // namespace divemesh::io
