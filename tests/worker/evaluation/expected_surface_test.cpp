#include "worker/evaluation/expected_surface.hpp"

#include <gtest/gtest.h>

namespace divemesh::evaluation {
namespace {

// Returns two triangles of the same size without common vertices.
types::Mesh two_triangles(float sigma_a,
                          float sigma_b,
                          std::uint32_t views_a,
                          std::uint32_t views_b) {
    types::Mesh mesh;
    for (const float x : {0.0F, 5.0F})
        for (const Eigen::Vector3f& corner :
             {Eigen::Vector3f(x, 0, 0), Eigen::Vector3f(x + 1, 0, 0), Eigen::Vector3f(x, 1, 0)})
            mesh.vertices.push_back(corner);
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    mesh.sigma_m = {sigma_a, sigma_a, sigma_a, sigma_b, sigma_b, sigma_b};
    mesh.num_observations = {views_a, views_a, views_a, views_b, views_b, views_b};
    return mesh;
}

TEST(ExpectedSurfaceTest, UniformSigmaGivesTheNormal95PercentError) {
    const auto surface = expected_surface(two_triangles(0.01F, 0.01F, 2, 7));
    ASSERT_TRUE(surface.has_value());
    EXPECT_NEAR(surface->error_95_m, 0.0196, 0.04 * 0.0196);  // bins are 4 % wide
    EXPECT_NEAR(surface->sigma_median_m, 0.01, 0.0004);
    EXPECT_EQ(surface->share_1_view, 0.0);
    EXPECT_NEAR(surface->share_2_views, 0.5, 1e-6);
    EXPECT_NEAR(surface->share_3_views_or_more, 0.5, 1e-6);
}

TEST(ExpectedSurfaceTest, TheNoisierHalfDeterminesTheError) {
    // 90 % of the noisy half must be within the error: 1.6449 of its sigma.
    const auto surface = expected_surface(two_triangles(0.01F, 0.1F, 3, 1));
    ASSERT_TRUE(surface.has_value());
    EXPECT_NEAR(surface->error_95_m, 0.16449, 0.04 * 0.16449);
    EXPECT_NEAR(surface->share_1_view, 0.5, 1e-6);
}

TEST(ExpectedSurfaceTest, AnEmptyMeshHasNoExpectedError) {
    EXPECT_FALSE(expected_surface({}).has_value());
}

}  // namespace
}  // namespace divemesh::evaluation
