#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/synthetic/altered_recording.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kDelay_s = 0.012;

// A dive whose right camera does not fire with the left one.
class LateCameraTest : public testing::Test {
protected:
    void simulate(simulator::SimulateOptions options) {
        options.scene = simulator::SceneKind::Barge;
        options.out = folder_ / "dive";
        options.seed = 3;
        options.width_px = 320;
        options.height_px = 240;
        simulator::simulate(options);
    }

    void open() { dive_ = dive::Dive::open(folder_ / "dive", folder_ / "scratch"); }

    double absolute_error_m(const synthetic::AlteredRecording::Alter& alter) {
        synthetic::AlteredRecording altered(*dive_, alter);
        AlignedRecording recording(altered);
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
    double compensated_error_m() {
        return absolute_error_m([](types::StereoFrame&) {});
    }
    double uncompensated_error_m() {
        return absolute_error_m([](types::StereoFrame& frame) { frame.right_delay_s = 0.0; });
    }

    TemporaryFolder folder_;
    std::unique_ptr<dive::Dive> dive_;
};

TEST_F(LateCameraTest, TheMotionBetweenTheExposuresIsTakenOff) {
    simulate({.length_m = 3.0, .stereo_offset_ms = 1e3 * kDelay_s});  // its stamps do not say so
    open();

    EXPECT_NEAR(dive_->frame(0).value().right_delay_s, kDelay_s, 0.003);
    const double compensated_m = compensated_error_m();
    EXPECT_LT(compensated_m, 0.005);
    EXPECT_LT(compensated_m, 0.5 * uncompensated_error_m());
}

}  // namespace
}  // namespace divemesh::pipeline
