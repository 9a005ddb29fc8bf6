#include "worker/optimisation/follow_keyframes.hpp"

#include <gtest/gtest.h>

namespace divemesh::optimisation {
namespace {

Eigen::Isometry3d at(double x_m) { return Eigen::Isometry3d(Eigen::Translation3d(x_m, 0.0, 0.0)); }

// Nine frames, by the odometry 0.1 m apart; keyframes 0 and 8 lie 1 m apart, not 0.8 m.
class FollowOverBreaksTest : public testing::Test {
protected:
    FollowOverBreaksTest() {
        for (int i = 0; i < 9; ++i) {
            odometry_.push_back({10 * i, at(0.1 * i)});
            sigmas_.push_back({0.01, 0.001});
        }
        keyframes_ = {{0, 0, at(0.0), 0}, {8, 80, at(1.0), 0}};
    }
    double x_m(int frame, const types::Breaks& breaks_ns) const {
        return follow_keyframes(
                   odometry_, sigmas_, keyframes_, Eigen::Isometry3d::Identity(), breaks_ns)
            .at(static_cast<std::size_t>(frame))
            .T_world_imu.translation()
            .x();
    }

    types::Trajectory odometry_;
    std::vector<types::MotionSigma> sigmas_;
    std::vector<types::Keyframe> keyframes_;
};

TEST_F(FollowOverBreaksTest, WithoutABreakEqualStepsHaveEqualPartsOfTheError) {
    EXPECT_NEAR(x_m(4, {}), 0.5, 1e-12);
    EXPECT_NEAR(x_m(2, {}), 0.25, 1e-12);
}

TEST_F(FollowOverBreaksTest, AnUncertainStepHasMostOfTheError) {
    sigmas_[6] = {0.05, 0.001};  // a variance of 25 others: 25 / 32 of the error
    EXPECT_NEAR(x_m(5, {}), 0.5 + 0.2 * 5.0 / 32.0, 1e-12);
    EXPECT_NEAR(x_m(6, {}), 0.6 + 0.2 * 30.0 / 32.0, 1e-12);
}

TEST_F(FollowOverBreaksTest, AnUncertainRotationHasMostOfTheErrorInRotation) {
    keyframes_[1].T_world_cam.rotate(Eigen::AngleAxisd(0.32, Eigen::Vector3d::UnitX()));
    sigmas_[6] = {0.01, 0.005};
    const types::Trajectory frames =
        follow_keyframes(odometry_, sigmas_, keyframes_, Eigen::Isometry3d::Identity());
    EXPECT_NEAR(Eigen::AngleAxisd(frames[5].T_world_imu.linear()).angle(), 0.05, 1e-9);
    EXPECT_NEAR(Eigen::AngleAxisd(frames[6].T_world_imu.linear()).angle(), 0.30, 1e-9);
}

TEST_F(FollowOverBreaksTest, AtRestNoErrorIsDistributed) {
    for (int i = 2; i <= 6; ++i) odometry_[static_cast<std::size_t>(i)].T_world_imu = at(0.2);
    for (std::size_t i = 3; i <= 6; ++i) sigmas_[i] = {};
    odometry_[7].T_world_imu = at(0.3);
    odometry_[8].T_world_imu = at(0.4);
    // The odometry moves in four steps, and is 0.6 m short.
    EXPECT_NEAR(x_m(1, {}), 0.25, 1e-12);
    for (int i = 2; i <= 6; ++i) EXPECT_NEAR(x_m(i, {}), 0.5, 1e-12) << i;
    EXPECT_NEAR(x_m(7, {}), 0.75, 1e-12);
}

TEST_F(FollowOverBreaksTest, WithABreakTheErrorLiesThere) {
    const types::Breaks breaks_ns = {40, 50};
    EXPECT_NEAR(x_m(3, breaks_ns), 0.3, 1e-12);  // tied to the first keyframe
    EXPECT_NEAR(x_m(5, breaks_ns), 0.7, 1e-12);  // tied to the second
    EXPECT_NEAR(x_m(7, breaks_ns), 0.9, 1e-12);
}

TEST_F(FollowOverBreaksTest, AfterABreakFramesBelongToTheNextSegment) {
    keyframes_[1].segment = 1;
    keyframes_[1].T_world_cam = at(50.0);
    const types::Breaks breaks_ns = {60};
    EXPECT_NEAR(x_m(5, breaks_ns), 0.5, 1e-12);
    EXPECT_NEAR(x_m(6, breaks_ns), 49.8, 1e-12);
}

TEST_F(FollowOverBreaksTest, FramesBeforeTheFirstKeyframeFollowItBackwards) {
    keyframes_ = {{3, 30, at(2.0), 0}};
    EXPECT_NEAR(x_m(0, {}), 1.7, 1e-12);
    EXPECT_NEAR(x_m(8, {}), 2.5, 1e-12);
}

}  // namespace
}  // namespace divemesh::optimisation
