#include "worker/optimisation/global_bundle_adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/tracked_dive.hpp"

namespace divemesh::optimisation {
namespace {

constexpr std::int32_t kNumKeyframes = 12;
constexpr std::int32_t kBreak = 6;
constexpr double kSigma_m = 0.3;
constexpr double kSigma_rad = 0.05;

// Removes the observations from before the break of every landmark that was seen after it.
void cut_at_the_break(types::Track& track) {
    for (types::Landmark& landmark : track.landmarks) {
        const bool later = landmark.observations.back().keyframe >= kBreak;
        std::erase_if(landmark.observations, [&](const types::LandmarkObservation& seen) {
            return later && seen.keyframe < kBreak;
        });
    }
}

class LostInBetweenTest : public testing::Test {
protected:
    LostInBetweenTest() : track_(synthetic::tracked_dive(kNumKeyframes)) {}

    // Returns the standard deviation of the position of a keyframe, m.
    double sigma_m(const std::vector<PredictedMotion>& predicted, std::size_t keyframe) {
        types::Track track = track_;
        const auto adjusted = adjust_globally(track.rig,
                                              imu::InertialPrior(recording_, {}),
                                              track.keyframes,
                                              track.landmarks,
                                              predicted,
                                              base::ignore_progress,
                                              {});
        return std::sqrt(adjusted.covariances.at(keyframe).position_m2.trace());
    }

    types::Track track_;
    synthetic::SensorRecording recording_;
};

TEST_F(LostInBetweenTest, TheCovarianceGrowsByTheMotionModel) {
    const double unbroken_m = sigma_m({}, kNumKeyframes - 1);
    cut_at_the_break(track_);
    const std::vector<PredictedMotion> predicted = {{kBreak, kSigma_m, kSigma_rad}};
    EXPECT_LT(sigma_m(predicted, kBreak - 1), 0.05);
    EXPECT_NEAR(sigma_m(predicted, kBreak), std::sqrt(3.0) * kSigma_m, 0.05);
    EXPECT_GT(sigma_m(predicted, kNumKeyframes - 1), sigma_m(predicted, kBreak));
    EXPECT_LT(unbroken_m, 0.05);
}

}  // namespace
}  // namespace divemesh::optimisation
