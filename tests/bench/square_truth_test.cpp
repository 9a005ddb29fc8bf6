#include "tests/bench/square_truth.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace divemesh::bench {
namespace {

using types::Mesh;

// Two triangles over [0, 1] x [0, 1].
Mesh sheet(const std::array<float, 4>& heights) {
    Mesh mesh;
    mesh.vertices = {
        {0, 0, heights[0]}, {1, 0, heights[1]}, {1, 1, heights[2]}, {0, 1, heights[3]}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

const Square kSquare{{0.2, 0.3}, 0.6};

double area_seen_from(const Mesh& mesh, const std::vector<Eigen::Vector3d>& cameras) {
    return true_surface_area_m2(kSquare, mesh, evaluation::SurfaceIndex(mesh), cameras);
}

SquareHeights heights_over(const Mesh& mesh) {
    const evaluation::SurfaceIndex index(mesh);
    return heights_of(kSquare, index, 5.0);
}

TEST(SquareTruthTest, APlaneAtSixtyDegreesHasTwiceTheArea) {
    const auto rise = static_cast<float>(std::numbers::sqrt3);
    const Mesh mesh = sheet({0.0F, rise, rise, 0.0F});
    const SquareHeights heights = heights_over(mesh);
    EXPECT_EQ(heights.share_known(), 1.0);
    EXPECT_NEAR(true_rugosity(heights, 0.1).value(), 2.0, 1e-5);
    EXPECT_NEAR(true_rugosity(heights, 0.25).value(), 2.0, 1e-5);
    EXPECT_NEAR(area_seen_from(mesh, {{0.5, 0.5, 10.0}}), 2.0 * 0.36, 1e-6);
    EXPECT_NEAR(true_range(heights).value().size_m(), 0.6 * std::numbers::sqrt3, 1e-5);
    // A wedge from 0.2 to 0.8: its mean height is that in the middle.
    EXPECT_NEAR(true_volume_m3(heights, 0.0), 0.36 * 0.5 * std::numbers::sqrt3, 1e-5);
    EXPECT_NEAR(true_slope_deg(heights), 60.0, 1e-4);
}

TEST(SquareTruthTest, WhatIsAboveHidesWhatIsBelowButAddsItsArea) {
    Mesh mesh = sheet({0.0F, 0.0F, 0.0F, 0.0F});
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, 1}, {0.5, 0, 1}, {0.5, 1, 1}, {0, 1, 1}});
    mesh.triangles.insert(mesh.triangles.end(), {{4, 5, 6}, {4, 6, 7}});
    const SquareHeights heights = heights_over(mesh);
    EXPECT_NEAR(true_range(heights).value().low_m, 0.0, 1e-6);
    EXPECT_NEAR(true_range(heights).value().high_m, 1.0, 1e-6);
    EXPECT_NEAR(true_volume_m3(heights, 0.0), 0.5 * 0.36, 2e-3);
    EXPECT_NEAR(area_seen_from(mesh, {{0.5, 0.5, 10.0}, {9.0, 0.5, 0.5}}), 1.5 * 0.36, 1e-6);
}

TEST(SquareTruthTest, WhatIsInsideOfAnObjectHasNoArea) {
    Mesh mesh = sheet({0.0F, 0.0F, 0.0F, 0.0F});
    // A roof with a ridge at x = 0.5, sunk 10 cm into the ground: 20 cm of it stand out.
    mesh.vertices.insert(mesh.vertices.end(),
                         {{0.2F, 0, -0.1F},
                          {0.5F, 0, 0.2F},
                          {0.8F, 0, -0.1F},
                          {0.2F, 1, -0.1F},
                          {0.5F, 1, 0.2F},
                          {0.8F, 1, -0.1F}});
    mesh.triangles.insert(mesh.triangles.end(), {{4, 5, 8}, {4, 8, 7}, {5, 6, 9}, {5, 9, 8}});
    const double ground_m2 = (0.6 - 0.4) * 0.6;
    const double roof_m2 = 2.0 * 0.2 * std::numbers::sqrt2 * 0.6;
    EXPECT_NEAR(area_seen_from(mesh, {{0.5, 0.5, 10.0}}), ground_m2 + roof_m2, 0.005);
}

TEST(SquareTruthTest, UnknownGroundCountsAsTheRestDoes) {
    Mesh half = sheet({0.5F, 0.5F, 0.5F, 0.5F});
    for (Eigen::Vector3f& vertex : half.vertices) vertex.y() *= 0.6F;  // half of the square
    const SquareHeights heights = heights_over(half);
    EXPECT_NEAR(heights.share_known(), 0.5, 0.002);
    EXPECT_NEAR(true_rugosity(heights, 0.1).value(), 1.0, 1e-6);
    EXPECT_NEAR(true_volume_m3(heights, 0.0), 0.5 * 0.36, 1e-6);
}

}  // namespace
}  // namespace divemesh::bench
