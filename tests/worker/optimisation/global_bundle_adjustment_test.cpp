#include "worker/optimisation/global_bundle_adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>

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

// Returns the motion of the body to a keyframe from the one before, as it is in the track.
Eigen::Isometry3d T_before(const types::Track& track, std::size_t keyframe) {
    return track.rig.T_imu_cam * track.keyframes[keyframe - 1].T_world_cam.inverse() *
           track.keyframes[keyframe].T_world_cam * track.rig.T_imu_cam.inverse();
}

class LostInBetweenTest : public testing::Test {
protected:
    LostInBetweenTest() : track_(synthetic::tracked_dive(kNumKeyframes)) {}

    // Returns the standard deviation of the position of a keyframe, m.
    double sigma_m(const std::vector<KnownMotion>& known, std::size_t keyframe) {
        types::Track track = track_;
        const auto adjusted = adjust_globally(
            track, imu::InertialPrior(recording_, {}), known, {}, base::ignore_progress, {});
        return std::sqrt(adjusted.covariances.at(keyframe).position_m2.trace());
    }

    types::Track track_;
    synthetic::SensorRecording recording_;
};

TEST_F(LostInBetweenTest, TheCovarianceGrowsByTheMotionModel) {
    const double unbroken_m = sigma_m({}, kNumKeyframes - 1);
    cut_at_the_break(track_);
    const std::vector<KnownMotion> unmeasured = {
        {kBreak, T_before(track_, kBreak), kSigma_m, kSigma_rad}};
    EXPECT_LT(sigma_m(unmeasured, kBreak - 1), 0.05);
    EXPECT_NEAR(sigma_m(unmeasured, kBreak), std::sqrt(3.0) * kSigma_m, 0.05);
    EXPECT_GT(sigma_m(unmeasured, kNumKeyframes - 1), sigma_m(unmeasured, kBreak));
    EXPECT_LT(unbroken_m, 0.05);
}

// Over a single interval of the IMU every direction of gravity fits some velocities.
class SingleIntervalTest : public testing::Test {
protected:
    SingleIntervalTest() { recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4}; }
    // Returns the standard deviation of the last position, m; nullopt without covariance.
    std::optional<double> last_sigma_m(int num_keyframes) const {
        types::Track track = synthetic::tracked_dive(num_keyframes);
        const auto adjusted = adjust_globally(
            track, imu::InertialPrior(recording_, {}), {}, {}, base::ignore_progress, {});
        if (adjusted.covariances.empty()) return std::nullopt;
        return std::sqrt(adjusted.covariances.back().position_m2.trace());
    }
    synthetic::SensorRecording recording_;
};

TEST_F(SingleIntervalTest, ADiveOfTwoKeyframesHasACovariance) {
    const auto by_vision_m = last_sigma_m(2);
    recording_.its_imu = synthetic::imu_along(synthetic::T_world_imu_at, 0.0, 0.5, {});
    const auto with_imu_m = last_sigma_m(2);
    ASSERT_TRUE(by_vision_m && with_imu_m);
    EXPECT_GT(*with_imu_m, 0.0);
    EXPECT_LT(*with_imu_m, 1.05 * *by_vision_m);
}

TEST_F(SingleIntervalTest, SoHasOneWhoseImuHasAGapAfterEach) {
    recording_.its_imu = synthetic::imu_along(synthetic::T_world_imu_at, 0.0, 1.5, {});
    std::erase_if(recording_.its_imu, [](const types::ImuSample& sample) {
        return sample.timestamp_ns > 550'000'000 && sample.timestamp_ns < 950'000'000;
    });
    EXPECT_TRUE(last_sigma_m(4));
}

// An error of the baseline scales the whole dive about its first camera.
TEST(CalibrationUncertaintyTest, TheBaselineIsTheScaleOfThePath) {
    constexpr double kSigma = 0.01;
    const synthetic::SensorRecording recording;
    const auto adjusted = [&](const CalibrationUncertainty& calibration) {
        types::Track track = synthetic::tracked_dive(kNumKeyframes);
        track.rig.T_imu_cam.translation().setZero();
        return std::pair(adjust_globally(track,
                                         imu::InertialPrior(recording, {}),
                                         {},
                                         calibration,
                                         base::ignore_progress,
                                         {}),
                         track.keyframes);
    };
    const auto by_baseline = [](const Eigen::Vector3d& measured_px) -> Eigen::Matrix3Xd {
        return Eigen::Vector3d(0.0, 0.0, measured_px.z());
    };
    const auto [exact, keyframes] = adjusted({});
    const auto [uncertain, same] =
        adjusted({by_baseline, Eigen::MatrixXd::Constant(1, 1, kSigma * kSigma), 0.0});

    const double length_m =
        (keyframes.back().T_world_cam.translation() - keyframes.front().T_world_cam.translation())
            .norm();
    const Eigen::Matrix3d added_m2 =
        uncertain.covariances.back().position_m2 - exact.covariances.back().position_m2;
    EXPECT_NEAR(std::sqrt(added_m2.trace()), kSigma * length_m, 0.05 * kSigma * length_m);
    EXPECT_NEAR(
        std::sqrt(std::pow(uncertain.path.scale_sigma, 2) - std::pow(exact.path.scale_sigma, 2)),
        kSigma,
        0.05 * kSigma);
}

}  // namespace
}  // namespace divemesh::optimisation
