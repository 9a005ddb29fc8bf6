#include "worker/compare/point_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace divemesh::compare {
namespace {

std::vector<Eigen::Vector3f> scattered(std::size_t num) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> any(-1.0F, 1.0F);
    std::vector<Eigen::Vector3f> points(num);
    for (Eigen::Vector3f& p : points) p = {any(random), any(random), 0.3F * any(random)};
    return points;
}

TEST(PointGrid, FindsTheSameNearestPointAsASearchOfAll) {
    const auto points = scattered(2000);
    const PointGrid grid(points, 0.07F);
    for (Eigen::Vector3f& p : scattered(300)) {
        const Eigen::Vector3f place = 1.2F * p + Eigen::Vector3f(0.01F, 0.02F, 0.0F);
        std::uint32_t best = 0;
        for (std::uint32_t i = 0; i < points.size(); ++i)
            if ((points[i] - place).norm() < (points[best] - place).norm()) best = i;
        const auto nearest = grid.nearest(place, 0.15F);
        if ((points[best] - place).norm() <= 0.15F)
            EXPECT_EQ(nearest, best);
        else
            EXPECT_EQ(nearest, std::nullopt);
    }
}

TEST(PointGrid, FindsWhatIsManyCubesAway) {
    const auto points = scattered(60);
    const PointGrid grid(points, 0.01F);
    for (const Eigen::Vector3f& p : scattered(200)) {
        const Eigen::Vector3f place = 1.5F * p + Eigen::Vector3f(0.03F, 0.0F, -0.02F);
        const auto distance = [&](const Eigen::Vector3f& q) { return (q - place).squaredNorm(); };
        const auto best = std::ranges::min_element(points, {}, distance);
        const auto nearest = grid.nearest(place, 0.8F);
        if (distance(*best) <= 0.8F * 0.8F)
            EXPECT_EQ(nearest, best - points.begin());
        else
            EXPECT_EQ(nearest, std::nullopt);
    }
}

TEST(PointGrid, FindsTheFirstOfEquallyNearPoints) {
    const std::vector<Eigen::Vector3f> points = {
        {0.3F, 0.0F, 0.0F}, {-0.3F, 0.0F, 0.0F}, {-0.3F, 0.0F, 0.0F}, {0.3F, 0.0F, 0.0F}};
    for (const float cell_m : {0.01F, 0.1F, 1.0F})
        EXPECT_EQ(PointGrid(points, cell_m).nearest({0.0F, 0.0F, 0.0F}, 0.5F), 0U) << cell_m;
}

TEST(PointGrid, FindsNothingAmongNoPoints) {
    const std::vector<Eigen::Vector3f> none;
    const PointGrid grid(none, 0.1F);
    EXPECT_EQ(grid.nearest({0.0F, 0.0F, 0.0F}, 1.0F), std::nullopt);
    grid.near_segment({0.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}, 0.1F, [](std::uint32_t) { FAIL(); });
}

TEST(PointGrid, VisitsEachPointOfACylinderOnce) {
    const auto points = scattered(4000);
    for (const float cell_m : {0.011F, 0.09F}) {
        const PointGrid grid(points, cell_m);
        for (const Eigen::Vector3f& way : scattered(50)) {
            const Eigen::Vector3f normal = way.normalized();
            std::multiset<std::uint32_t> visited;
            grid.near_segment(way - 0.4F * normal, way + 0.4F * normal, 0.1F, [&](std::uint32_t i) {
                visited.insert(i);
            });
            for (std::uint32_t i = 0; i < points.size(); ++i) {
                const Eigen::Vector3f from = points[i] - way;
                const float along = from.dot(normal);
                const bool inside =
                    std::abs(along) <= 0.4F && (from - along * normal).norm() <= 0.1F;
                EXPECT_LE(visited.count(i), 1U);
                if (inside) {
                    EXPECT_EQ(visited.count(i), 1U);
                }
            }
        }
    }
}

}  // namespace
}  // namespace divemesh::compare
