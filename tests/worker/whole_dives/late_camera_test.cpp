#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kDelay_s = 0.012;

// A dive whose right camera is late, and whose stamps do not say so.
class LateCameraTest : public testing::Test {
protected:
    LateCameraTest() {
        simulator::simulate({.scene = simulator::SceneKind::Barge,
                             .out = folder_ / "dive",
                             .length_m = 3.0,
                             .seed = 3,
                             .width_px = 320,
                             .height_px = 240,
                             .stereo_offset_ms = 1e3 * kDelay_s});
        dive_ = dive::Dive::open(folder_ / "dive", folder_ / "scratch");
    }

    double absolute_error_m(double right_delay_s) {
        AlignedRecording recording(*dive_);
        types::Rig rig = dive_->rig();
        rig.right_delay_s = right_delay_s;
        recording.set_rig(rig);
        recording.rewind();
        const keyframes::KeyframeStore store(folder_ / "keyframes");
        const auto options = make_options("standard", {{"surface", false}, {"num_threads", 1}});
        const types::Track track =
            pipeline::track(recording, options, store, base::ignore_progress);
        EXPECT_EQ(track.sigmas.size(), track.odometry.size());
        const types::OptimisedTrack path =
            pipeline::optimise(track, recording, options, store, {}, base::ignore_progress);
        return evaluation::trajectory_error(path.trajectory, dive_->ground_truth()).ate_rmse_m;
    }

    TemporaryFolder folder_;
    std::unique_ptr<dive::Dive> dive_;
};

TEST_F(LateCameraTest, TheMotionBetweenTheExposuresIsTakenOff) {
    EXPECT_NEAR(dive_->rig().right_delay_s, kDelay_s, 0.003);
    const double compensated_m = absolute_error_m(dive_->rig().right_delay_s);
    const double as_recorded_m = absolute_error_m(0.0);
    EXPECT_LT(compensated_m, 0.005);
    EXPECT_LT(compensated_m, 0.5 * as_recorded_m);
}

}  // namespace
}  // namespace divemesh::pipeline
