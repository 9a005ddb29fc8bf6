#include "worker/imu/sensor_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/swaying_rig.hpp"
#include "worker/imu/usable_samples.hpp"

namespace divemesh::imu {
namespace {

constexpr int kNumFrames = 400;  // 40 s at 10 Hz
constexpr std::int64_t kFrame_ns = 100'000'000;

// A dive whose IMU readings `wrong` changes.
template <typename Wrong>
synthetic::SensorRecording dive(const Wrong& wrong) {
    synthetic::SensorRecording recording;
    recording.its_rig.imu_noise = types::ImuNoise{};
    recording.its_imu =
        synthetic::imu_along(synthetic::T_world_swaying, -1.5, 0.1 * kNumFrames + 1.5, {});
    for (types::ImuSample& sample : recording.its_imu) wrong(sample);
    return recording;
}

// The watch after the dive, and how many frames it took until it asked for a restart.
struct Watched {
    SensorWatch watch;
    int num_frames = 0;
};

Watched watched(const types::Recording& recording, const SensorPlan& plan = {}, int lost_at = -1) {
    InertialPrior inertial(recording, preset_options("standard"), plan.left_out);
    Watched result{SensorWatch(recording, {.imu = true, .ahrs = true}, plan)};
    for (int k = 1; k <= kNumFrames && !result.watch.restart(); ++k) {
        result.num_frames = k;
        if (lost_at <= k && k < lost_at + 4) {
            result.watch.lost_scene();
            continue;
        }
        const double from_s = 0.1 * (k - 1);
        const double to_s = 0.1 * k;
        result.watch.watch(
            {std::llround(1e9 * from_s),
             std::llround(1e9 * to_s),
             synthetic::T_world_swaying(from_s).inverse() * synthetic::T_world_swaying(to_s)},
            inertial);
    }
    return result;
}

void as_measured(types::ImuSample&) {}
void mirrored(types::ImuSample& sample) {
    sample.angular_velocity_imu.z() *= -1.0;
    sample.acceleration_imu.z() *= -1.0;
}

TEST(SensorWatchTest, AGoodImuStaysInUse) {
    const Watched seen = watched(dive(as_measured));
    EXPECT_FALSE(seen.watch.restart());
    EXPECT_FALSE(seen.watch.restart_at_end());
}

TEST(SensorWatchTest, AMirroredImuIsLeftOutWithinSeconds) {
    const Watched seen = watched(dive(mirrored));
    ASSERT_TRUE(seen.watch.restart());
    EXPECT_TRUE(seen.watch.restart()->left_out.imu);
    EXPECT_EQ(seen.watch.restart()->gyroscope.axes, "z");
    EXPECT_LT(seen.num_frames, 150);
}

TEST(SensorWatchTest, AClockThatIsOffIsShifted) {
    const Watched seen =
        watched(dive([](types::ImuSample& sample) { sample.timestamp_ns += 400'000'000; }));
    ASSERT_TRUE(seen.watch.restart());
    EXPECT_FALSE(seen.watch.restart()->left_out.imu);
    EXPECT_NEAR(seen.watch.restart()->alignment.time_offset_s, 0.4, 0.01);
}

TEST(SensorWatchTest, AnOffsetThatWasLearntLateIsUsedFromTheStart) {
    const synthetic::SensorRecording recording = dive(as_measured);
    SensorWatch watch(recording, {.imu = true, .ahrs = false}, {});
    watch.aligned({.time_offset_s = 0.006}, 40);
    EXPECT_FALSE(watch.restart());
    watch.aligned({.time_offset_s = 0.025}, 60);
    ASSERT_TRUE(watch.restart());
    EXPECT_EQ(watch.restart()->alignment.time_offset_s, 0.025);
    EXPECT_EQ(watch.restart()->num_alignment_rotations, 60U);
    EXPECT_FALSE(watch.restart()->left_out.imu);
    SensorWatch next(recording, {.imu = true, .ahrs = false}, *watch.restart());
    next.aligned({.time_offset_s = 0.026}, 90);
    EXPECT_FALSE(next.restart());
}

TEST(SensorWatchTest, AnAccelerometerWithOtherAxesIsLeftOutAndTheGyroscopeStays) {
    const Watched seen = watched(dive([](types::ImuSample& sample) {
        std::swap(sample.acceleration_imu.x(), sample.acceleration_imu.y());
    }));
    ASSERT_TRUE(seen.watch.restart());
    EXPECT_TRUE(seen.watch.restart()->left_out.accelerometer);
    EXPECT_FALSE(seen.watch.restart()->left_out.imu);
}

TEST(SensorWatchTest, ALossBeforeTheImuIsConfirmedPutsItOnProbation) {
    const synthetic::SensorRecording recording = dive(as_measured);
    const Watched lost = watched(recording, {}, 20);
    ASSERT_TRUE(lost.watch.restart());
    EXPECT_TRUE(lost.watch.restart()->imu_unconfirmed);
    // It fits, so it is used again, and a loss at the same place is not its fault.
    const Watched probed = watched(recording, *lost.watch.restart(), 20);
    ASSERT_TRUE(probed.watch.restart());
    EXPECT_FALSE(probed.watch.restart()->left_out.imu);
    EXPECT_FALSE(watched(recording, *probed.watch.restart(), 20).watch.restart());
}

TEST(SensorWatchTest, AnImuThatFailsInTheMiddleIsLeftOutForThatTime) {
    const auto fails = [](types::ImuSample& sample) {
        if (sample.timestamp_ns > 15'000'000'000 && sample.timestamp_ns < 25'000'000'000)
            mirrored(sample);
    };
    const Watched seen = watched(dive(fails));
    EXPECT_FALSE(seen.watch.restart());
    const auto plan = seen.watch.restart_at_end();
    ASSERT_TRUE(plan);
    ASSERT_EQ(plan->left_out.imu_times.size(), 1U);
    const types::TimeInterval time = plan->left_out.imu_times[0];
    EXPECT_LT(time.from_ns, 15'000'000'000);
    EXPECT_GT(time.from_ns, 8'000'000'000);
    EXPECT_GT(time.to_ns, 25'000'000'000);
    EXPECT_LT(time.to_ns, 40'000'000'000);
}

// Expects that the samples from 18 to 22 s are left out, and few others.
void expect_left_out(const types::Recording& recording) {
    const Watched seen = watched(recording);
    EXPECT_FALSE(seen.watch.restart());
    const auto plan = seen.watch.restart_at_end();
    ASSERT_TRUE(plan);
    EXPECT_FALSE(plan->left_out.imu);
    const auto usable = usable_rates(recording, plan->left_out);
    for (const types::ImuSample& sample : usable)
        EXPECT_FALSE(sample.timestamp_ns > 18'000'000'000 && sample.timestamp_ns < 22'000'000'000);
    const double num_left_out = static_cast<double>(recording.imu().size() - usable.size());
    EXPECT_LT(num_left_out, 200.0 * 8.0);
    // Without these rows nothing is wrong.
    EXPECT_FALSE(watched(recording, *plan).watch.restart_at_end());
}

TEST(SensorWatchTest, AGyroscopeThatFailsForSecondsIsLeftOutForThem) {
    expect_left_out(dive([](types::ImuSample& sample) {
        if (sample.timestamp_ns < 18'000'000'000 || sample.timestamp_ns > 22'000'000'000) return;
        sample.angular_velocity_imu << 0.4, -0.3, 0.2;
    }));
}

TEST(SensorWatchTest, AnAccelerometerThatFailsForSecondsIsLeftOutForThem) {
    expect_left_out(dive([](types::ImuSample& sample) {
        if (sample.timestamp_ns < 18'000'000'000 || sample.timestamp_ns > 22'000'000'000) return;
        sample.acceleration_imu << 3.0, 3.0, 9.0;
    }));
}

TEST(SensorWatchTest, NoiseOfSecondsIsLeftOut) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    expect_left_out(dive([&](types::ImuSample& sample) {
        if (sample.timestamp_ns < 18'000'000'000 || sample.timestamp_ns > 22'000'000'000) return;
        for (int axis = 0; axis < 3; ++axis) {
            sample.angular_velocity_imu[axis] += 3.0 * normal(random);
            sample.acceleration_imu[axis] += 10.0 * normal(random);
        }
    }));
}

TEST(SensorWatchTest, AnAhrsIsJudgedWithoutAnImu) {
    synthetic::SensorRecording recording;
    for (int k = 0; k <= 10 * kNumFrames; ++k) {
        const double t_s = 0.01 * k;
        recording.its_ahrs.push_back(
            {std::llround(1e9 * t_s),
             Eigen::Quaterniond(synthetic::T_world_swaying(t_s).linear())});
    }
    EXPECT_FALSE(watched(recording).watch.restart_at_end());
    for (types::OrientationSample& sample : recording.its_ahrs)
        sample.q_world_imu = sample.q_world_imu.conjugate();
    const auto plan = watched(recording).watch.restart_at_end();
    ASSERT_TRUE(plan);
    EXPECT_TRUE(plan->left_out.ahrs);
    EXPECT_EQ(plan->ahrs.fault, AhrsFault::Inverse);
    EXPECT_FALSE(watched(recording, *plan).watch.restart_at_end());
}

// Frames at which vision contradicts the IMU; single ones may be spoilt images.
TEST(SensorWatchTest, WhatFramesContradictForATimeIsLeftOutThen) {
    const synthetic::SensorRecording recording = dive(as_measured);
    Watched watched_dive = watched(recording);
    watched_dive.watch.contradicted_in({10 * kFrame_ns, 11 * kFrame_ns});
    EXPECT_FALSE(watched_dive.watch.restart_at_end());
    for (int k = 100; k < 105; ++k)
        watched_dive.watch.contradicted_in({k * kFrame_ns, (k + 1) * kFrame_ns});
    const auto plan = watched_dive.watch.restart_at_end();
    ASSERT_TRUE(plan);
    ASSERT_EQ(plan->left_out.imu_times.size(), 1U);
    EXPECT_NEAR(static_cast<double>(plan->left_out.imu_times[0].from_ns), 1e10, 3e8);
    EXPECT_NEAR(static_cast<double>(plan->left_out.imu_times[0].to_ns), 1.05e10, 3e8);
    EXPECT_FALSE(plan->left_out.imu);
}

}  // namespace
}  // namespace divemesh::imu
