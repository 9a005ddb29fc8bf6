#include "worker/calibration/undo_rolling_shutter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/synthetic/ideal_rig.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/tracked_dive.hpp"
#include "worker/calibration/calibration_refinement.hpp"

namespace divemesh::calibration {
namespace {

constexpr int kNumKeyframes = 24;
constexpr double kFramesPerSecond = 10.0;

// The path of stereo_world.hpp by a diver in the swell.
Eigen::Isometry3d swaying(double frame) {
    Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(frame);
    T_world_cam.translation() +=
        Eigen::Vector3d(0.06 * std::sin(0.31 * frame), 0.05 * std::sin(0.43 * frame), 0.0);
    T_world_cam.rotate(
        Eigen::AngleAxisd(0.05 * std::sin(0.37 * frame + 1.0), Eigen::Vector3d::UnitY()));
    T_world_cam.rotate(Eigen::AngleAxisd(0.04 * std::sin(0.29 * frame), Eigen::Vector3d::UnitZ()));
    return T_world_cam;
}

// Returns (u, v, disparity) of a point in the image whose middle row is read at a frame's time.
Eigen::Vector3d seen_through(double readout_time_s,
                             const types::RectifiedRig& rig,
                             double frame,
                             const Eigen::Vector3d& p_world) {
    Eigen::Vector3d seen = types::project_px(rig, swaying(frame).inverse() * p_world);
    for (int i = 0; i < 10; ++i) {
        const double late_s = readout_time_s * (seen.y() / rig.height_px - 0.5);
        seen =
            types::project_px(rig, swaying(frame + kFramesPerSecond * late_s).inverse() * p_world);
    }
    return seen;
}

class RollingShutterTest : public testing::Test {
protected:
    RollingShutterTest() { recording_.its_rig = synthetic::ideal_cameras(track_.rig); }

    // Replaces every observation by what the shutter shows of the landmark.
    void expose(double readout_time_s, double noise_px) {
        std::mt19937 random(3);
        std::normal_distribution<double> normal(0.0, 1.0);
        for (types::Landmark& landmark : track_.landmarks)
            for (types::LandmarkObservation& seen : landmark.observations) {
                const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
                const Eigen::Vector3f px =
                    (seen_through(readout_time_s, track_.rig, frame_of(seen), landmark.p_world) +
                     noise_px * noise)
                        .cast<float>();
                seen.u_px = px.x();
                seen.v_px = px.y();
                seen.disparity_px = px.z();
            }
    }
    types::RefinedCalibration refined() const {
        return refine_calibration(track_,
                                  recording_,
                                  {},
                                  {},
                                  imu::InertialPrior(recording_, {}, {}),
                                  base::ignore_progress,
                                  {})
            .calibration;
    }
    double frame_of(const types::LandmarkObservation& seen) const {
        return track_.keyframes[static_cast<std::size_t>(seen.keyframe)].frame_index;
    }

    types::Track track_ = synthetic::tracked_dive(kNumKeyframes, swaying);
    synthetic::SensorRecording recording_;
};

TEST_F(RollingShutterTest, UndoneItIsAGlobalShutter) {
    expose(0.03, 0.0);
    const auto motions = camera_motions(track_, track_.keyframes);
    const auto rms_px = [&] {
        double squares_px2 = 0.0;
        double num = 0.0;
        for (const types::Landmark& landmark : track_.landmarks)
            for (const types::LandmarkObservation& seen : landmark.observations) {
                if (!motions[static_cast<std::size_t>(seen.keyframe)]) continue;
                const Eigen::Vector3d off =
                    seen_through(0.0, track_.rig, frame_of(seen), landmark.p_world) -
                    Eigen::Vector3d(seen.u_px, seen.v_px, seen.disparity_px);
                squares_px2 += off.squaredNorm();
                num += 1.0;
            }
        return std::sqrt(squares_px2 / num);
    };
    const double before_px = rms_px();
    undo_rolling_shutter(recording_.its_rig, 0.03, track_);
    EXPECT_GT(before_px, 0.5);
    EXPECT_LT(rms_px(), 0.1 * before_px);
}

TEST_F(RollingShutterTest, ItsReadoutTimeIsFound) {
    for (const double readout_time_s : {0.02, -0.015}) {
        expose(readout_time_s, 0.25);
        const types::RefinedCalibration found = refined();
        EXPECT_NEAR(found.readout_time_s, readout_time_s, 0.1 * std::abs(readout_time_s));
        EXPECT_TRUE(found.readout_time_applied) << found.readout_time_sigma_s;
        EXPECT_GT(found.readout_shift_px, 0.2);
    }
}

TEST_F(RollingShutterTest, AGlobalShutterHasNone) {
    const types::RefinedCalibration found = refined();
    EXPECT_GT(found.readout_time_sigma_s, 0.0);
    EXPECT_LT(std::abs(found.readout_time_s), 2e-3);
    EXPECT_FALSE(found.readout_time_applied);
}

TEST_F(RollingShutterTest, MotionOverALongTimeIsNotUniform) {
    for (types::StampedPose& pose : track_.odometry) pose.timestamp_ns *= 4;
    for (types::Keyframe& keyframe : track_.keyframes) keyframe.timestamp_ns *= 4;
    const auto motions = camera_motions(track_, track_.keyframes);
    ASSERT_FALSE(motions.empty());
    for (const auto& motion : motions) EXPECT_FALSE(motion);
    EXPECT_EQ(refined().readout_time_sigma_s, 0.0);  // not estimated
}

}  // namespace
}  // namespace divemesh::calibration
