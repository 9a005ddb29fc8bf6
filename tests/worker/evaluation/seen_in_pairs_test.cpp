#include "worker/evaluation/seen_in_pairs.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/ideal_rig.hpp"

namespace divemesh::evaluation {
namespace {

// Pairs whose left camera looks along z from these x, at y = z = 0. At 1 m an image shows 1 x 2 m.
StereoPairs pairs_at(const std::vector<double>& xs_m) {
    StereoPairs pairs{synthetic::ideal_cameras(synthetic::ideal_rig(500, 1000, 500.0)), {}};
    for (const double x_m : xs_m)
        pairs.T_world_cam0.emplace_back(Eigen::Translation3d(x_m, 0.0, 0.0));
    return pairs;
}

// Returns a square of 1 m around the axis, at a depth.
types::Mesh square(float depth_m) {
    types::Mesh mesh;
    mesh.vertices = {{-0.5F, -0.5F, depth_m},
                     {0.5F, -0.5F, depth_m},
                     {0.5F, 0.5F, depth_m},
                     {-0.5F, 0.5F, depth_m}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

class SeenInPairsTest : public testing::Test {
protected:
    bool is_seen(const Eigen::Vector3f& point, const StereoPairs& pairs, int min_pairs = 1) const {
        return SeenInPairs(pairs, Eigen::Isometry3d::Identity(), surface_, 3.0)
            .is_seen(point, min_pairs);
    }

    types::Mesh mesh_ = square(2.0F);
    SurfaceIndex surface_{mesh_};
};

TEST_F(SeenInPairsTest, APointMustBeInBothImages) {
    EXPECT_TRUE(is_seen({0.3F, 0.0F, 1.0F}, pairs_at({0.0})));
    // The right camera is 12 cm to the right: its image begins at x = -0.38.
    EXPECT_TRUE(is_seen({-0.37F, 0.0F, 1.0F}, pairs_at({0.0})));
    EXPECT_FALSE(is_seen({-0.39F, 0.0F, 1.0F}, pairs_at({0.0})));
    EXPECT_FALSE(is_seen({0.51F, 0.0F, 1.0F}, pairs_at({0.0})));
    EXPECT_FALSE(is_seen({0.0F, 0.0F, -1.0F}, pairs_at({0.0})));
}

TEST_F(SeenInPairsTest, WhatLiesBehindTheSurfaceIsHidden) {
    EXPECT_TRUE(is_seen({0.0F, 0.0F, 2.0F}, pairs_at({0.0})));
    EXPECT_FALSE(is_seen({0.0F, 0.0F, 2.5F}, pairs_at({0.0})));
    EXPECT_TRUE(is_seen({0.9F, 0.0F, 2.5F}, pairs_at({0.0}))) << "it lies beside the square";
}

TEST_F(SeenInPairsTest, PairsFartherAwayThanTheRangeDoNotCount) {
    EXPECT_TRUE(is_seen({0.0F, 1.0F, 2.8F}, pairs_at({0.0})));   // 2.97 m
    EXPECT_FALSE(is_seen({0.0F, 1.1F, 2.8F}, pairs_at({0.0})));  // 3.01 m
}

TEST_F(SeenInPairsTest, SoManyPairsMustSeeIt) {
    const Eigen::Vector3f point(0.0F, 0.0F, 1.0F);
    EXPECT_TRUE(is_seen(point, pairs_at({-0.1, 0.0, 0.1, 5.0}), 3));
    EXPECT_FALSE(is_seen(point, pairs_at({-0.1, 0.0, 4.0, 5.0}), 3));
}

TEST_F(SeenInPairsTest, OfManyPairsEqualStepsCount) {
    std::vector<double> xs_m(100'000, 50.0);
    for (std::size_t i = 60'000; i < 61'000; ++i) xs_m[i] = 0.0;
    EXPECT_TRUE(is_seen({0.0F, 0.0F, 1.0F}, pairs_at(xs_m), 3));
}

// The polynomial of this lens decreases beyond a tangent of 1.05 and reaches the image again.
TEST_F(SeenInPairsTest, TheFoldOfADistortionShowsNothing) {
    StereoPairs pairs = pairs_at({0.0});
    for (types::Camera* camera : {&pairs.rig.cam0, &pairs.rig.cam1}) {
        camera->width_px = camera->height_px = 400;
        camera->cx_px = camera->cy_px = 199.5;
        camera->distortion = types::Distortion::RadialTangential;
        camera->distortion_coefficients = {-0.3, 0.0, 0.0, 0.0};
    }
    EXPECT_TRUE(is_seen({0.1F, 0.0F, 1.0F}, pairs));
    EXPECT_FALSE(is_seen({1.8F, 0.0F, 1.0F}, pairs));
}

}  // namespace
}  // namespace divemesh::evaluation
