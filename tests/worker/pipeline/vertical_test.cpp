#include "worker/pipeline/vertical.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr int kNumKeyframes = 60;  // a second apart

// Returns a path of lanes of 2 m along x; the lanes fill a width along y, m.
types::OptimisedTrack lanes(double width_m) {
    types::OptimisedTrack track;
    for (int k = 0; k < kNumKeyframes; ++k) {
        types::Keyframe keyframe;
        keyframe.timestamp_ns = k * kSecond_ns;
        keyframe.T_world_cam.translation() =
            Eigen::Vector3d(0.2 * (k % 10), width_m * k / (kNumKeyframes - 1), 0.0);
        track.trajectory.push_back({keyframe.timestamp_ns, keyframe.T_world_cam});
        track.covariances.emplace_back();
        track.keyframes.push_back(keyframe);
    }
    return track;
}

synthetic::SensorRecording with_pressure() {
    synthetic::SensorRecording recording;
    for (int i = 0; i <= 2 * kNumKeyframes; ++i)
        recording.its_pressure.push_back({i * kSecond_ns / 2, 12.0});
    return recording;
}

bool is_known(const types::Recording& recording, const types::OptimisedTrack& track) {
    return vertical_is_known(imu::InertialPrior(recording, ReconstructionOptions{}), track);
}

TEST(VerticalTest, ImagesAloneDoNotTellWhichWayIsUp) {
    EXPECT_FALSE(is_known(synthetic::SensorRecording(), lanes(2.0)));
}

TEST(VerticalTest, AnAccelerometerThatMeasuresGravityTells) {
    synthetic::SensorRecording recording;
    recording.its_rig.imu_noise = types::ImuNoise{};
    for (int i = 0; i < 200; ++i)
        recording.its_imu.push_back(
            {i * kSecond_ns / 200, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    EXPECT_TRUE(is_known(recording, lanes(0.0)));
    for (types::ImuSample& sample : recording.its_imu) sample.acceleration_imu *= 0.5;
    EXPECT_FALSE(is_known(recording, lanes(0.0)));
}

TEST(VerticalTest, AnAccelerometerThatBeginsLateTellsOnlyWhereTheWholeDiveWasAdjusted) {
    synthetic::SensorRecording recording;
    recording.its_rig.imu_noise = types::ImuNoise{};
    for (int i = 0; i < 200; ++i)
        recording.its_imu.push_back(
            {30 * kSecond_ns + i * kSecond_ns / 200, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    types::OptimisedTrack track = lanes(0.0);
    EXPECT_TRUE(is_known(recording, track));
    track.covariances.clear();
    EXPECT_FALSE(is_known(recording, track));
}

TEST(VerticalTest, AnAhrsTells) {
    synthetic::SensorRecording recording;
    recording.its_ahrs.push_back({0, Eigen::Quaterniond::Identity()});
    EXPECT_TRUE(is_known(recording, lanes(0.0)));
}

// The depths have sigma 20 mm each. Over lanes of 2 m by `width` the standard deviation of the tilt
// about x is 0.02 / (width sqrt(60 / 12)): 4.5 mrad for 2 m, 90 mrad for 0.1 m.
TEST(VerticalTest, PressureTellsOverAPathThatIsNoLine) {
    EXPECT_TRUE(is_known(with_pressure(), lanes(2.0)));
    EXPECT_FALSE(is_known(with_pressure(), lanes(0.1)));
    EXPECT_FALSE(is_known(with_pressure(), lanes(0.0)));
}

TEST(VerticalTest, PressureTellsOnlyWhereTheWholeDiveWasAdjustedInOneSegment) {
    types::OptimisedTrack track = lanes(2.0);
    track.covariances.clear();
    EXPECT_FALSE(is_known(with_pressure(), track));
    track = lanes(2.0);
    track.keyframes.back().segment = 1;
    EXPECT_FALSE(is_known(with_pressure(), track));
}

}  // namespace
}  // namespace divemesh::pipeline
