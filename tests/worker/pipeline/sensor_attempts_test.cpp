#include "worker/pipeline/sensor_attempts.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/swaying_rig.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kNumFrames = 100;

// Attempts to track a dive with a readable IMU in which the scene is lost.
class SensorAttemptsTest : public testing::Test {
protected:
    SensorAttemptsTest() {
        recording_.its_rig.imu_noise = types::ImuNoise{};
        for (int i = 0; i < 2000; ++i)
            recording_.its_imu.push_back(
                {i * std::int64_t{5'000'000}, {0.1, 0.0, 1e-3 * (i % 7)}, {0.0, 0.0, 9.8}});
    }
    // Returns whether the dive is tracked anew after vision measured so many frames.
    bool again(SensorAttempts& attempts, int num_measured, bool loses_scene = false) const {
        imu::SensorWatch watch(recording_, {.imu = true, .ahrs = false}, attempts.plan());
        for (int i = 0; loses_scene && i < 3; ++i) watch.lost_scene();
        types::Track track;
        track.motions.assign(kNumFrames, types::MotionSource::Nothing);
        std::fill_n(track.motions.begin(), num_measured, types::MotionSource::Vision);
        return attempts.again(watch, track);
    }
    // Returns attempts of which the second, by vision alone, measured so many frames.
    SensorAttempts alone(int num_measured, bool expect_trial) const {
        SensorAttempts attempts(recording_);
        EXPECT_FALSE(attempts.plan().left_out.imu);
        EXPECT_TRUE(again(attempts, 3, true));
        EXPECT_TRUE(attempts.plan().left_out.imu);
        EXPECT_TRUE(attempts.plan().imu_unconfirmed);
        EXPECT_EQ(again(attempts, num_measured), expect_trial);
        return attempts;
    }

    synthetic::SensorRecording recording_;
};

TEST_F(SensorAttemptsTest, VisionAloneIsEnoughIfItLosesLittle) {
    EXPECT_TRUE(alone(95, false).plan().left_out.imu);
}

TEST_F(SensorAttemptsTest, AnUnconfirmedImuThatFindsTheSceneAgainIsUsed) {
    SensorAttempts attempts = alone(50, true);
    EXPECT_FALSE(attempts.plan().left_out.imu);
    EXPECT_TRUE(attempts.plan().imu_confirmed);
    EXPECT_FALSE(again(attempts, 80));
    EXPECT_FALSE(attempts.plan().left_out.imu);
    EXPECT_FALSE(attempts.plan().imu_unconfirmed);
}

TEST_F(SensorAttemptsTest, AnUnconfirmedImuThatDoesNotFindTheSceneIsLeftOut) {
    SensorAttempts attempts = alone(50, true);
    EXPECT_TRUE(again(attempts, 52));
    EXPECT_TRUE(attempts.plan().left_out.imu);
    EXPECT_FALSE(again(attempts, 50));
}

TEST_F(SensorAttemptsTest, AClippedAccelerometerIsNotUsedFromTheStart) {
    for (std::size_t i = 0; i < recording_.its_imu.size(); ++i)
        recording_.its_imu[i].acceleration_imu.z() =
            i / 100 % 2 == 0 ? 10.0 : 9.0 + 1e-3 * static_cast<double>(i % 100);
    const SensorAttempts attempts(recording_);
    EXPECT_TRUE(attempts.plan().left_out.accelerometer);
    EXPECT_FALSE(attempts.plan().left_out.imu);
}

TEST_F(SensorAttemptsTest, AClockThatIsNeverRightEndsWithoutTheImu) {
    SensorAttempts attempts(recording_);
    for (int attempt = 1; attempt <= 4; ++attempt) {
        EXPECT_FALSE(attempts.plan().left_out.imu) << attempt;
        imu::SensorWatch watch(recording_, {.imu = true, .ahrs = false}, attempts.plan());
        watch.aligned({.time_offset_s = 0.03 * attempt}, 40);
        EXPECT_TRUE(attempts.again(watch, {}));
    }
    EXPECT_TRUE(attempts.plan().left_out.imu);
    EXPECT_TRUE(attempts.plan().imu_unsettled);
    EXPECT_FALSE(again(attempts, kNumFrames));
}

// Attempts to track a dive of two minutes whose IMU fits, but for four seconds that each attempt
// finds elsewhere.
TEST(SensorAttemptsOfAGoodImuTest, OneMoreBadSecondDoesNotCostTheImu) {
    constexpr int kFrames = 1200;  // at 10 Hz
    synthetic::SensorRecording good;
    good.its_rig.imu_noise = types::ImuNoise{};
    good.its_imu = synthetic::imu_along(synthetic::T_world_swaying, -1.5, 0.1 * kFrames + 1.5, {});
    const auto again = [&](SensorAttempts& attempts, std::int64_t fails_at_s) {
        synthetic::SensorRecording recording = good;
        for (types::ImuSample& sample : recording.its_imu)
            if (std::abs(sample.timestamp_ns - fails_at_s * 1'000'000'000) < 2'000'000'000)
                sample.angular_velocity_imu << 0.4, -0.3, 0.2;
        imu::InertialPrior inertial(
            recording, preset_options("standard"), attempts.plan().left_out);
        imu::SensorWatch watch(recording, {.imu = true, .ahrs = false}, attempts.plan());
        for (int k = 1; k <= kFrames; ++k)
            watch.watch({base::to_ns(0.1 * (k - 1)),
                         base::to_ns(0.1 * k),
                         synthetic::T_world_swaying(0.1 * (k - 1)).inverse() *
                             synthetic::T_world_swaying(0.1 * k)},
                        inertial);
        EXPECT_FALSE(watch.restart()) << fails_at_s;
        types::Track track;
        track.motions.assign(kFrames, types::MotionSource::Vision);
        return attempts.again(watch, track);
    };
    SensorAttempts attempts(good);
    for (const std::int64_t fails_at_s : {17, 37, 57, 77}) {
        EXPECT_TRUE(again(attempts, fails_at_s)) << fails_at_s;
        EXPECT_FALSE(attempts.plan().left_out.imu) << fails_at_s;
    }
    EXPECT_FALSE(again(attempts, 97));
    EXPECT_FALSE(attempts.plan().left_out.imu);
    EXPECT_EQ(attempts.plan().left_out.imu_times.size(), 5U);
}

}  // namespace
}  // namespace divemesh::pipeline
