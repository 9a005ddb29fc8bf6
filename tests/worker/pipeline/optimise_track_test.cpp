#include "worker/pipeline/optimise_track.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
    types::OptimisedTrack optimised() const {
        return optimise_track(track_,
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
    const types::OptimisedTrack result = optimised();
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
    const types::OptimisedTrack result = optimised();
    ASSERT_EQ(result.findings.size(), 1U);
    EXPECT_EQ(result.findings[0].code, "adjustment_not_taken");
    EXPECT_EQ(result.findings[0].severity, Severity::Warning);
    EXPECT_TRUE(result.covariances.empty());
    EXPECT_THAT(whole_way(result.trajectory),
                synthetic::IsPoseWithin(whole_way(track_.causal), 1e-6, 1e-9));
}

}  // namespace
}  // namespace divemesh::pipeline
