#include "worker/loops/motions_in_sight.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::loops {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// Ten steps of one second, keyframes at both ends and in the middle.
class MotionsInSightTest : public testing::Test {
protected:
    MotionsInSightTest() {
        for (int i = 0; i <= 10; ++i)
            track_.odometry.push_back({i * kSecond_ns, Eigen::Isometry3d::Identity()});
        track_.keyframes = {{0, 0}, {5, 5 * kSecond_ns}, {10, 10 * kSecond_ns}};
        track_.motions.assign(11, types::MotionSource::Vision);
        track_.motions[0] = types::MotionSource::Nothing;
        track_.sigmas.assign(11, {0.003, 0.002});
    }
    types::Track track_;
};

TEST_F(MotionsInSightTest, TheVariancesOfTheStepsAddUp) {
    const auto motions = motions_in_sight(track_);
    ASSERT_EQ(motions.size(), 3U);
    EXPECT_FALSE(motions[0]);
    ASSERT_TRUE(motions[1]);
    EXPECT_NEAR(motions[1]->position_m, std::sqrt(5.0) * 0.003, 1e-12);
    EXPECT_NEAR(motions[1]->rotation_rad, std::sqrt(5.0) * 0.002, 1e-12);
}

TEST_F(MotionsInSightTest, OneStepThatVisionDidNotMeasureLeavesTheMotionUnknown) {
    track_.motions[7] = types::MotionSource::Imu;
    const auto motions = motions_in_sight(track_);
    EXPECT_TRUE(motions[1]);
    EXPECT_FALSE(motions[2]);
}

TEST_F(MotionsInSightTest, ARestAddsItsOwnErrorOnce) {
    for (std::size_t i = 6; i <= 9; ++i) track_.sigmas[i] = {};
    track_.rests = {{6 * kSecond_ns, 9 * kSecond_ns, 0.004, 0.005}};
    const auto motions = motions_in_sight(track_);
    ASSERT_TRUE(motions[2]);
    EXPECT_NEAR(motions[2]->position_m, std::hypot(0.003, 0.004), 1e-12);
    EXPECT_NEAR(motions[2]->rotation_rad, std::hypot(0.002, 0.005), 1e-12);
    EXPECT_NEAR(motions[1]->position_m, std::sqrt(5.0) * 0.003, 1e-12);
}

}  // namespace
}  // namespace divemesh::loops
