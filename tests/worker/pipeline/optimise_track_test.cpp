#include "worker/pipeline/optimise_track.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/synthetic/floor_swim.hpp"
#include "tests/synthetic/ideal_rig.hpp"
#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/tracked_dive.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kNumKeyframes = 16;

class OptimiseTrackTest : public testing::Test {
protected:
    OptimiseTrackTest() {
        recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        recording_.its_imu =
            synthetic::imu_along(synthetic::T_world_imu_at, 0.0, 0.5 * kNumKeyframes, {});
        options_.close_loops = false;
        options_.align_imu = false;
        options_.refine_lenses = false;
    }
    types::OptimisedTrack optimised(const types::Track& track) const {
        return optimise_track(track,
                              recording_,
                              options_,
                              keyframes::KeyframeStore(folder_.path()),
                              {},
                              base::ignore_progress);
    }
    static Eigen::Isometry3d whole_way(const types::Trajectory& trajectory) {
        return trajectory.front().T_world_imu.inverse() * trajectory.back().T_world_imu;
    }

    const types::Track track_ = synthetic::tracked_dive(kNumKeyframes);
    synthetic::SensorRecording recording_;
    ReconstructionOptions options_;
    TemporaryFolder folder_;
};

TEST_F(OptimiseTrackTest, TakesAnAdjustmentThatAgreesWithWhatWasMeasured) {
    const types::OptimisedTrack result = optimised(track_);
    EXPECT_TRUE(result.findings.empty());
    EXPECT_EQ(result.statistics.bundle_adjustment.num_converged, 1);
    EXPECT_LT(result.statistics.bundle_adjustment.final_cost,
              result.statistics.bundle_adjustment.initial_cost);
    EXPECT_LE(result.statistics.check.after.reprojection_rms_px,
              result.statistics.check.before.reprojection_rms_px);
    EXPECT_FALSE(result.covariances.empty());
    EXPECT_THAT(whole_way(result.trajectory),
                synthetic::IsPoseWithin(whole_way(track_.causal), 0.1, 0.005));
}

// The gyroscope of another dive, trusted with the noise of its data sheet, bends the path.
TEST_F(OptimiseTrackTest, LeavesTheTrackAsItWasWhereAnAdjustmentDiverges) {
    for (types::ImuSample& sample : recording_.its_imu) {
        const double t_s = 1e-9 * static_cast<double>(sample.timestamp_ns);
        sample.angular_velocity_imu += Eigen::Vector3d(0.8, 0.5, -0.6) * std::sin(2.0 * t_s);
    }
    const types::OptimisedTrack result = optimised(track_);
    ASSERT_EQ(result.findings.size(), 1U);
    EXPECT_EQ(result.findings[0].code, "adjustment_not_taken");
    EXPECT_EQ(result.findings[0].severity, Severity::Warning);
    EXPECT_TRUE(result.covariances.empty());
    EXPECT_THAT(whole_way(result.trajectory),
                synthetic::IsPoseWithin(whole_way(track_.causal), 1e-6, 1e-9));
}

// A window left a landmark where no solver can begin.
TEST_F(OptimiseTrackTest, StartsAgainFromTheOdometryWhereAnAdjustmentDiverges) {
    types::Track track = track_;
    track.landmarks[3].p_world.setConstant(std::numeric_limits<double>::quiet_NaN());
    const types::OptimisedTrack result = optimised(track);
    EXPECT_EQ(result.statistics.bundle_adjustment.num_solves, 2);
    EXPECT_EQ(result.statistics.bundle_adjustment.num_failed, 1);
    EXPECT_TRUE(result.findings.empty());
    EXPECT_FALSE(result.covariances.empty());
    EXPECT_THAT(whole_way(result.trajectory),
                synthetic::IsPoseWithin(whole_way(track_.causal), 0.1, 0.005));
}

// The path of stereo_world.hpp with strokes: the rig surges by up to 1.5 m/s^2.
Eigen::Isometry3d surging(double frame) {
    Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(frame);
    T_world_cam.translation().x() += 0.06 * std::sin(0.5 * frame);
    return T_world_cam;
}

// A low-pass filter delays the gyroscope, and not the accelerometer beside it. The refinement sees
// the gyroscope alone and takes its delay for the clock's, so the accelerometer comes out of step.
TEST_F(OptimiseTrackTest, LeavesACalibrationThatTheAccelerometerContradicts) {
    constexpr double kDelay_s = 0.1;
    const types::Track track = synthetic::tracked_dive(kNumKeyframes, surging);
    const auto T_world_imu_at = [&](double t_s) {
        return Eigen::Isometry3d(surging(10.0 * t_s) * track.rig.T_imu_cam.inverse());
    };
    recording_.its_rig = synthetic::ideal_cameras(track.rig);
    recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 1e-4, 2e-4};
    recording_.its_imu = synthetic::imu_along(T_world_imu_at, 0.0, 0.5 * kNumKeyframes, {});
    const auto late =
        synthetic::imu_along(T_world_imu_at, -kDelay_s, 0.5 * kNumKeyframes - kDelay_s, {});
    for (std::size_t i = 0; i < late.size(); ++i)
        recording_.its_imu[i].angular_velocity_imu = late[i].angular_velocity_imu;
    options_.align_imu = true;
    const types::OptimisedTrack result = optimised(track);
    EXPECT_GT(result.calibration.imu.time_offset_s, 0.5 * kDelay_s);
    ASSERT_EQ(result.findings.size(), 1U);
    EXPECT_EQ(result.findings[0].code, "calibration_not_taken");
    EXPECT_EQ(result.findings[0].severity, Severity::Warning);
    EXPECT_FALSE(result.calibration.is_applied());
    EXPECT_THAT(whole_way(result.trajectory),
                synthetic::IsPoseWithin(whole_way(track.causal), 0.1, 0.005));
}

// The rig comes back over ground that was pushed aside by a decimetre while it was out of sight:
// the drift allows the loops, and closing them tears apart what was tracked without error.
TEST_F(OptimiseTrackTest, LeavesLoopsOutThatContradictWhatWasTracked) {
    synthetic::Path path;
    synthetic::Path shown;
    for (const double x_m : {0.0, 0.4, 0.8, 1.6, 2.4, 1.6, 0.8, 0.4, 0.0}) {
        const bool came_back = path.size() > 4;
        path.push_back(synthetic::above_floor(x_m, 0.0, 0.0));
        shown.push_back(synthetic::above_floor(x_m, came_back ? 0.1 : 0.0, 0.0));
    }
    const synthetic::FloorSwim swim(synthetic::SeaFloor(), path, 0.0, shown);
    options_.use_imu = false;
    options_.close_loops = true;
    const types::OptimisedTrack result =
        optimise_track(swim.track, recording_, options_, swim.store, {}, base::ignore_progress);
    EXPECT_GE(result.statistics.loops.num_matched, 2);
    EXPECT_EQ(result.statistics.loops.num_accepted, 0);
    ASSERT_EQ(result.findings.size(), 1U);
    EXPECT_EQ(result.findings[0].code, "loops_not_taken");
    EXPECT_EQ(result.findings[0].severity, Severity::Warning);
    EXPECT_THAT(whole_way(result.trajectory),
                synthetic::IsPoseWithin(whole_way(swim.track.causal), 0.01, 0.001));
}

}  // namespace
}  // namespace divemesh::pipeline
