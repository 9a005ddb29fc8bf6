#include "worker/pipeline/reconstruct.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/tracked_dive.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kNumKeyframes = 12;

class OptimiseTest : public testing::Test {
protected:
    OptimiseTest() {
        options_.use_imu = false;
        options_.close_loops = false;
        options_.refine_lenses = false;
        track_.motions.assign(track_.causal.size(), types::MotionSource::Vision);
    }
    types::OptimisedTrack optimised() const {
        return optimise(track_,
                        recording_,
                        options_,
                        keyframes::KeyframeStore(folder_.path()),
                        {},
                        base::ignore_progress);
    }
    void move_landmarks() {
        for (std::size_t i = 0; i < track_.landmarks.size(); ++i)
            track_.landmarks[i].p_world.y() += i % 2 == 0 ? 0.3 : -0.3;
    }
    // Returns true if the first finding says that the result diverged.
    static bool diverged(const types::OptimisedTrack& result) {
        return !result.findings.empty() && result.findings.front().code == "diverged" &&
               result.findings.front().severity == Severity::Error;
    }

    types::Track track_ = synthetic::tracked_dive(kNumKeyframes);
    synthetic::SensorRecording recording_;
    ReconstructionOptions options_;
    TemporaryFolder folder_;
};

TEST_F(OptimiseTest, ATrackThatNothingAdjustsIsCheckedToo) {
    options_.adjust_whole_dive = false;
    const types::OptimisedTrack good = optimised();
    EXPECT_FALSE(diverged(good));
    EXPECT_GT(good.statistics.check.after.reprojection_rms_px, 0.0);
    move_landmarks();
    EXPECT_TRUE(diverged(optimised()));
}

TEST_F(OptimiseTest, ADivergedResultSaysHowItsSolversEnded) {
    // Observations that no path and no landmark explains.
    for (std::size_t i = 0; i < track_.landmarks.size(); ++i)
        for (types::LandmarkObservation& seen : track_.landmarks[i].observations)
            seen.u_px += (static_cast<int>(i) + seen.keyframe) % 2 == 0 ? 8.0F : -8.0F;
    const types::OptimisedTrack result = optimised();
    ASSERT_TRUE(diverged(result));
    EXPECT_GT(result.statistics.bundle_adjustment.num_solves, 0);
}

}  // namespace
}  // namespace divemesh::pipeline
