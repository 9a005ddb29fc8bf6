#include "worker/odometry/motion_model.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/stereo_world.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr double kVelocity_m_s = 0.2;

class MotionModelTest : public testing::Test {
protected:
    MotionModelTest() : motion_(synthetic::rig(), inertial_) {
        Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
        T_current_previous.translation().x() = -0.1 * kVelocity_m_s;
        motion_.start(0, Eigen::Isometry3d::Identity());
        motion_.advance(T_current_previous, kSecond_ns / 10);
        motion_.confirm_by_vision();
    }

    // Returns how far the rig moves to a time, as predicted.
    double predicted_m(std::int64_t timestamp_ns) const {
        return -motion_.predict(std::nullopt, timestamp_ns).translation().x();
    }

    synthetic::SensorRecording recording_;
    imu::InertialPrior inertial_{recording_, {}};
    MotionModel motion_;
};

TEST_F(MotionModelTest, TheNextFrameOfAVideoIsPredictedReliably) {
    EXPECT_TRUE(motion_.predicts_reliably(2 * kSecond_ns / 10));
    EXPECT_NEAR(predicted_m(2 * kSecond_ns / 10), 0.1 * kVelocity_m_s, 1e-9);
}

TEST_F(MotionModelTest, WithoutAnImuTheFrameAfterTwoSecondsIsNot) {
    EXPECT_FALSE(motion_.predicts_reliably(21 * kSecond_ns / 10));
    EXPECT_LT(predicted_m(21 * kSecond_ns / 10), 2.0 * kVelocity_m_s);
}

}  // namespace
}  // namespace divemesh::odometry
