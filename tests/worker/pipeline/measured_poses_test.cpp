#include "worker/pipeline/measured_poses.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::pipeline {
namespace {

using types::MotionSource;

constexpr std::int64_t kPeriod_ns = 100'000'000;

// Returns a track of ten frames a second, given what measured the motion to each frame: 'v' vision,
// 'i' the IMU, '-' nothing. The given frames are keyframes.
types::Track track_of(const std::string& motions, const std::vector<int>& keyframes) {
    types::Track track;
    for (std::size_t i = 0; i < motions.size(); ++i) {
        const types::StampedPose pose{static_cast<std::int64_t>(i) * kPeriod_ns,
                                      Eigen::Isometry3d::Identity()};
        track.causal.push_back(pose);
        track.odometry.push_back(pose);
        track.motions.push_back(motions[i] == 'v'   ? MotionSource::Vision
                                : motions[i] == 'i' ? MotionSource::Imu
                                                    : MotionSource::Nothing);
    }
    for (const int frame : keyframes)
        track.keyframes.push_back({.frame_index = frame, .timestamp_ns = frame * kPeriod_ns});
    track.mapped = track.keyframes;
    track.breaks_ns = breaks_of(track);
    return track;
}

// Returns which frames were measured, as a text: 'x' measured, '.' not.
std::string measured(const types::Track& track) {
    std::string text;
    for (const bool is : measured_frames(track.odometry, track.breaks_ns, track.keyframes))
        text += is ? 'x' : '.';
    return text;
}

TEST(MeasuredFramesTest, FramesBetweenLossAndReturnAreNotMeasured) {
    // Frame 6 is the first that frame 7 is measured against.
    EXPECT_EQ(measured(track_of("-vv----vv", {0, 7})), "xxx...xxx");
}

TEST(MeasuredFramesTest, ADiveThatBeginsInTheDarkBeginsWithItsFirstMotion) {
    EXPECT_EQ(measured(track_of("----vvv", {0, 4})), "...xxxx");
}

TEST(MeasuredFramesTest, LinkedFramesWithoutAKeyframeAreNotMeasured) {
    EXPECT_EQ(measured(track_of("-vv--v--vv", {0, 8})), "xxx....xxx");
}

TEST(MeasuredFramesTest, AFrameWithoutMotionIsMeasuredOnlyIfItIsTheOnlyOne) {
    EXPECT_EQ(measured(track_of("----", {0})), "....");
    EXPECT_EQ(measured(track_of("-", {0})), "x");
}

TEST(DropUnmeasuredKeyframesTest, TheirObservationsGoAndTheOthersKeepTheirs) {
    types::Track track = track_of("---vvv", {0, 3, 5});
    types::Landmark seen_in_the_dark;
    seen_in_the_dark.observations = {{.keyframe = 0}};
    types::Landmark seen_later;
    seen_later.observations = {{.keyframe = 0}, {.keyframe = 1}, {.keyframe = 2}};
    track.landmarks = {seen_in_the_dark, seen_later};
    drop_unmeasured_keyframes(track);
    ASSERT_EQ(track.keyframes.size(), 2U);
    EXPECT_EQ(track.keyframes[0].frame_index, 3);
    EXPECT_EQ(track.mapped.size(), 2U);
    ASSERT_EQ(track.landmarks.size(), 1U);
    ASSERT_EQ(track.landmarks[0].observations.size(), 2U);
    EXPECT_EQ(track.landmarks[0].observations[0].keyframe, 0);
    EXPECT_EQ(track.landmarks[0].observations[1].keyframe, 1);
}

TEST(SetPredictedApartTest, EachPoseIsInOneOfTheTwoWithItsCovariance) {
    const types::Track track = track_of("-vv----vv", {0, 7});
    types::OptimisedTrack result;
    result.trajectory = track.odometry;
    result.breaks_ns = track.breaks_ns;
    result.keyframes = track.keyframes;
    result.mapped = track.mapped;
    result.mapped.push_back({.frame_index = 4, .timestamp_ns = 4 * kPeriod_ns});
    for (const types::StampedPose& pose : track.odometry)
        result.covariances.push_back({.timestamp_ns = pose.timestamp_ns});
    set_predicted_apart(result);
    ASSERT_EQ(result.predicted.size(), 3U);
    EXPECT_EQ(result.predicted.front().timestamp_ns, 3 * kPeriod_ns);
    ASSERT_EQ(result.trajectory.size(), 6U);
    ASSERT_EQ(result.covariances.size(), 6U);
    EXPECT_EQ(result.covariances[3].timestamp_ns, result.trajectory[3].timestamp_ns);
    EXPECT_EQ(result.mapped.size(), 2U);
}

class BridgeByImuTest : public testing::Test {
protected:
    BridgeByImuTest() {
        recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        recording_.its_imu = synthetic::imu_along(synthetic::T_world_imu_at, 0.0, 4.0, {});
    }
    // Returns the motions after bridging: 'i' by the IMU.
    std::string bridged(const std::string& motions) const {
        types::Track track = track_of(motions, {0});
        bridge_by_imu(imu::InertialPrior(recording_, {}), track);
        std::string text;
        for (const MotionSource source : track.motions)
            text += source == MotionSource::Vision ? 'v' : source == MotionSource::Imu ? 'i' : '-';
        return text;
    }

    synthetic::SensorRecording recording_;
};

TEST_F(BridgeByImuTest, AGapOfASecondIsMeasuredByTheImu) {
    EXPECT_EQ(bridged("-vviiiivv"), "-vviiiivv");
    EXPECT_EQ(bridged("-vviiiiiiiiiivv"), "-vviiiiiiiiiivv");
}

TEST_F(BridgeByImuTest, ALongerGapIsNotMeasured) {
    EXPECT_EQ(bridged("-vviiiiiiiiiiivv"), "-vv-----------vv");
}

TEST_F(BridgeByImuTest, AGapWithVisionOnOneSideOnlyIsNotMeasured) {
    EXPECT_EQ(bridged("-iivv"), "---vv");
    EXPECT_EQ(bridged("-vvii"), "-vv--");
}

TEST_F(BridgeByImuTest, AGapThatTheImuHasTooIsNotMeasured) {
    std::erase_if(recording_.its_imu, [](const types::ImuSample& sample) {
        return sample.timestamp_ns > 3 * kPeriod_ns && sample.timestamp_ns < 5 * kPeriod_ns;
    });
    EXPECT_EQ(bridged("-vviiiivv"), "-vv----vv");
}

TEST_F(BridgeByImuTest, AGapThatTheImuDidNotPredictThroughoutIsNotMeasured) {
    EXPECT_EQ(bridged("-vv----vv"), "-vv----vv");
    EXPECT_EQ(bridged("-vvii-ivv"), "-vv----vv");
}

}  // namespace
}  // namespace divemesh::pipeline
