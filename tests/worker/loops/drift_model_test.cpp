#include "worker/loops/drift_model.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::loops {
namespace {

// Twelve keyframes half a second apart; before the seventh the scene was lost for `blind_s`.
struct Dive {
    explicit Dive(double blind_s) {
        double now_s = 0.0;
        for (int k = 0; k < 12; ++k) {
            if (k > 0) now_s += k == 6 ? blind_s : 0.5;
            types::Keyframe keyframe;
            keyframe.frame_index = k;
            keyframe.timestamp_ns = std::llround(1e9 * now_s);
            keyframe.T_world_cam = synthetic::T_world_cam(10.0 * now_s);
            keyframes.push_back(keyframe);
            for (int i = 0; i < 20 && k > 0 && k != 6; ++i)
                landmarks.push_back({Eigen::Vector3d::Zero(), {{k - 1}, {k}}});
        }
        recording.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        recording.its_imu = synthetic::imu_along(synthetic::T_world_imu_at, 0.0, now_s, {});
    }

    DriftModel with_inertia() const {
        const imu::InertialPrior inertial(recording, {});
        return {keyframes, landmarks, &inertial};
    }
    DriftModel without() const { return {keyframes, landmarks, nullptr}; }

    std::vector<types::Keyframe> keyframes;
    std::vector<types::Landmark> landmarks;
    synthetic::SensorRecording recording;
};

TEST(DriftModelTest, InertiaCarriesTheTrackOverThreeSecondsWithoutSight) {
    const Dive dive(3.0);
    EXPECT_TRUE(dive.with_inertia().follows(6));
    EXPECT_LT(dive.with_inertia().position_sigma_m(5, 6), 0.25);
    EXPECT_GT(dive.with_inertia().position_sigma_m(5, 6), 0.05);
    EXPECT_LT(dive.with_inertia().orientation_sigma_rad(5, 6), 0.02);
}

TEST(DriftModelTest, NothingBridgesTenSecondsOrThreeWithoutSensors) {
    EXPECT_FALSE(Dive(10.0).with_inertia().follows(6));
    EXPECT_FALSE(Dive(3.0).without().follows(6));
    EXPECT_TRUE(Dive(0.8).without().follows(6));
    EXPECT_GT(Dive(3.0).without().position_sigma_m(5, 6), 0.8);
}

TEST(DriftModelTest, InertiaDoesNotBridgeAGapInTheSamples) {
    Dive dive(3.0);
    std::erase_if(dive.recording.its_imu, [](const types::ImuSample& sample) {
        return sample.timestamp_ns > 3'500'000'000 && sample.timestamp_ns < 4'000'000'000;
    });
    EXPECT_FALSE(dive.with_inertia().follows(6));
}

TEST(DriftModelTest, FramesThatKeepTheSceneInSightConnectKeyframesWithoutLandmarks) {
    const Dive dive(10.0);
    MotionsInSight in_sight(dive.keyframes.size());
    in_sight[6] = {0.02, 0.01};
    const DriftModel drift(dive.keyframes, dive.landmarks, nullptr, in_sight);
    EXPECT_TRUE(drift.follows(6));
    EXPECT_EQ(drift.segment(6), drift.segment(5));
    ASSERT_TRUE(drift.by_frames_alone(6));
    EXPECT_FALSE(drift.by_frames_alone(5));
    const double without_sight_m = dive.without().position_sigma_m(5, 6);
    EXPECT_LT(drift.position_sigma_m(5, 6), without_sight_m - 2.5);
    EXPECT_GE(drift.position_sigma_m(5, 6), 0.02);
}

TEST(DriftModelTest, AFewSharedLandmarksLeaveTheLoopToTheKeyframeBeforeToBeMeasured) {
    Dive dive(10.0);
    for (int i = 0; i < 3; ++i) dive.landmarks.push_back({Eigen::Vector3d::Zero(), {{5}, {6}}});
    const DriftModel drift = dive.without();
    EXPECT_EQ(drift.first_covisible(5), 3U);
    EXPECT_EQ(drift.first_covisible(6), 6U);
    EXPECT_EQ(drift.first_covisible(7), 6U);
}

}  // namespace
}  // namespace divemesh::loops
