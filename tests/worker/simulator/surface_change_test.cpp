#include "worker/simulator/surface_change.hpp"

#include <gtest/gtest.h>

namespace divemesh::simulator {
namespace {

// Returns a plane with a box half sunk into its middle, and another box beside it that appears or
// disappears.
Scene place(int year, SceneBuilder::Fate fate) {
    SceneBuilder builder(1, year, Eigen::Isometry3f::Identity());
    builder.add(
        "ground",
        Material::Sand,
        make_height_field({-2.0F, 2.0F, -2.0F, 2.0F}, 0.05F, [](float, float) { return 0.0F; }),
        place_at({0, 0, 0}));
    builder.add("stays", Material::Rock, make_box({0.4F, 0.4F, 0.4F}, 0.02F), place_at({-1, 0, 0}));
    builder.add_changing(
        "box", Material::Rock, make_box({0.6F, 0.4F, 0.5F}, 0.02F), place_at({1, 0, 0}), fate);
    return builder.finish({}, 5.0);
}

TEST(SurfaceChange, ANewBoxCountsAsFarAsItStandsOut) {
    const auto fate = SceneBuilder::Fate::New;
    const auto changes = surface_changes(place(1, fate), place(2, fate));
    ASSERT_EQ(changes.size(), 1U);
    EXPECT_TRUE(changes[0].grown);
    EXPECT_EQ(changes[0].names, std::vector<std::string>{"box"});
    EXPECT_NEAR(changes[0].area_m2, 0.24, 0.004);
    EXPECT_NEAR(changes[0].volume_m3, 0.24 * 0.25, 0.001);
}

TEST(SurfaceChange, ABoxThatGrowsAddsARimAndALid) {
    const auto fate = SceneBuilder::Fate::Grows;
    const auto changes = surface_changes(place(1, fate), place(2, fate));
    ASSERT_EQ(changes.size(), 1U);
    constexpr double kBefore_m3 = 0.24 * 0.25;
    EXPECT_NEAR(changes[0].volume_m3, kBefore_m3 * (343.0 / 216.0 - 1.0), 0.001);
}

TEST(SurfaceChange, WhatIsGoneIsLost) {
    const auto fate = SceneBuilder::Fate::Lost;
    const auto changes = surface_changes(place(1, fate), place(2, fate));
    ASSERT_EQ(changes.size(), 1U);
    EXPECT_FALSE(changes[0].grown);
    EXPECT_NEAR(changes[0].volume_m3, 0.24 * 0.25, 0.001);
}

}  // namespace
}  // namespace divemesh::simulator
