#include "worker/base/nearest_to_rays.hpp"

#include <gtest/gtest.h>

namespace divemesh::base {
namespace {

constexpr double kMinParallax = 1e-6;

std::vector<Ray> rays_through(const Eigen::Vector3d& point) {
    std::vector<Ray> rays;
    for (const Eigen::Vector3d& origin :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0.2, 0), Eigen::Vector3d(-0.5, 0.8, 0.1)})
        rays.push_back({origin, 0.3 * (point - origin)});
    return rays;
}

TEST(NearestToRaysTest, FindsThePointWhereTheRaysMeet) {
    const Eigen::Vector3d point(0.4, -0.3, 2.0);
    const auto found = nearest_to_rays(rays_through(point), kMinParallax);

    ASSERT_TRUE(found);
    EXPECT_LT((*found - point).norm(), 1e-12);
}

TEST(NearestToRaysTest, OfTwoRaysThatMissEachOtherItIsHalfwayBetweenThem) {
    const auto found =
        nearest_to_rays({{{0, 0, 1}, {5, 0, 0}}, {{0, 3, 2}, {0, 1, 0}}}, kMinParallax);

    ASSERT_TRUE(found);
    EXPECT_LT((*found - Eigen::Vector3d(0, 0, 1.5)).norm(), 1e-12);
}

TEST(NearestToRaysTest, RaysThatAreAlmostParallelDetermineNoPoint) {
    const std::vector<Ray> rays = {{{0, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {1e-3, 0, 1}}};

    EXPECT_FALSE(nearest_to_rays(rays, 1e-6));
    EXPECT_TRUE(nearest_to_rays(rays, 1e-7));  // the mean squared sine is 2.5e-7
}

TEST(NearestToRaysTest, FewerThanTwoRaysDetermineNoPoint) {
    EXPECT_FALSE(nearest_to_rays({}, kMinParallax));
    EXPECT_FALSE(nearest_to_rays({{{0, 0, 0}, {1, 2, 3}}}, kMinParallax));
}

}  // namespace
}  // namespace divemesh::base
