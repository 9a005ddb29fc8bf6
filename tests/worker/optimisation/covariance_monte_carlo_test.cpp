#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <random>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/optimisation/residual_field.hpp"

namespace divemesh::optimisation {
namespace {

constexpr int kNumRuns = 100;
constexpr int kNumKeyframes = 8;
constexpr int kStep = 5;  // frames of 0.1 s between keyframes
constexpr double kDuration_s = 0.1 * kStep * kNumKeyframes;
constexpr std::int64_t kEveryNthPoint = 5;

constexpr double kDisparityBias_px = 0.03;  // standard deviation
constexpr double kClockSigma_s = 1e-3;
constexpr double kTriangulationSigma = 0.0015;  // of the scale

// Returns what an error of all disparities does to a measurement.
Eigen::Matrix3Xd shift_of(const Eigen::Vector3d& /*measured_px*/) {
    return Eigen::Vector3d::UnitZ();
}

CalibrationUncertainty calibration() {
    return {shift_of,
            Eigen::MatrixXd::Constant(1, 1, kDisparityBias_px * kDisparityBias_px),
            kClockSigma_s};
}

// The path of stereo_world.hpp, with errors of features, gyroscope, accelerometer, cameras and
// clocks as large as the bundle adjustment assumes, and a field of errors fixed in the image; no
// images.
class NoisyDive {
public:
    // The IMU is recorded so much longer at both ends.
    NoisyDive(double margin_s, double field_sigma_px) : field_sigma_px_(field_sigma_px) {
        recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        exact_ =
            synthetic::imu_along(synthetic::T_world_imu_at, -margin_s, kDuration_s + margin_s, {});
    }

    // Returns the squared normalised error of the last position relative to the first pose.
    double nees(std::uint32_t seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        const auto noise = [&] {
            return Eigen::Vector3d(normal(random), normal(random), normal(random));
        };
        recording_.its_imu = exact_;
        const types::ImuNoise sigma = imu::InertialPrior(recording_, {}).noise();
        const double root_rate = std::sqrt(200.0);
        const Eigen::Vector3d gyroscope_bias = 0.005 * noise();
        const Eigen::Vector3d accelerometer_bias = 0.05 * noise();
        const auto late_ns = std::llround(1e9 * kClockSigma_s * normal(random));
        for (types::ImuSample& sample : recording_.its_imu) {
            sample.timestamp_ns += late_ns;
            sample.angular_velocity_imu +=
                gyroscope_bias + sigma.gyroscope_noise_density * root_rate * noise();
            sample.acceleration_imu +=
                accelerometer_bias + sigma.accelerometer_noise_density * root_rate * noise();
        }
        const double disparity_bias_px = kDisparityBias_px * normal(random);
        Eigen::Matrix<double, kFieldSize, 1> nodes_px;
        for (double& node_px : nodes_px) node_px = field_sigma_px_ * normal(random);
        synthetic::World world(0.03 * kStep * kNumKeyframes, 0.0, seed);
        types::Track track;
        std::map<std::int64_t, types::Landmark> seen;
        for (int k = 0; k <= kNumKeyframes; ++k) {
            const int frame = kStep * k;
            const Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(frame);
            track.keyframes.push_back({frame, 100'000'000LL * frame, T_world_cam});
            if (k > 0) track.keyframes.back().T_world_cam.translation() += 0.005 * noise();
            for (types::Feature feature : world.see(T_world_cam, frame, 0.0)) {
                if (feature.id % kEveryNthPoint != 0) continue;
                const Eigen::Vector3d measured_px(
                    feature.pixel.x(), feature.pixel.y(), feature.disparity_px);
                const Eigen::Vector3d error = types::kFeatureSigma_px.cwiseProduct(noise()) +
                                              disparity_bias_px * Eigen::Vector3d::UnitZ() +
                                              by_field(synthetic::rig(), measured_px) * nodes_px;
                feature.pixel += error.head<2>();
                feature.disparity_px += error.z();
                const Eigen::Vector3d p = track.keyframes.back().T_world_cam *
                                          types::point_cam(synthetic::rig(), feature);
                seen.try_emplace(feature.id, types::Landmark{p, {}})
                    .first->second.observations.push_back(
                        {k,
                         static_cast<float>(feature.pixel.x()),
                         static_cast<float>(feature.pixel.y()),
                         static_cast<float>(feature.disparity_px)});
            }
        }
        for (auto& [id, landmark] : seen)
            if (landmark.observations.size() > 1) track.landmarks.push_back(std::move(landmark));
        track.rig = synthetic::rig();
        track.rig.baseline_m *= 1.0 + kTriangulationSigma * normal(random);
        const GlobalBundleAdjustment adjusted = adjust_globally(track,
                                                                imu::InertialPrior(recording_, {}),
                                                                {},
                                                                calibration(),
                                                                base::ignore_progress,
                                                                {});
        return normalised(track.rig, track.keyframes, adjusted.covariances);
    }

private:
    static double normalised(const types::RectifiedRig& rig,
                             const std::vector<types::Keyframe>& keyframes,
                             const types::CovarianceTrack& covariances) {
        const auto relative = [&](const Eigen::Isometry3d& first, const Eigen::Isometry3d& last) {
            const Eigen::Isometry3d T_cam_imu = rig.T_imu_cam.inverse();
            return Eigen::Vector3d(
                ((first * T_cam_imu).inverse() * (last * T_cam_imu)).translation());
        };
        const Eigen::Vector3d error =
            relative(keyframes.front().T_world_cam, keyframes.back().T_world_cam) -
            relative(synthetic::T_world_cam(0), synthetic::T_world_cam(kStep * kNumKeyframes));
        return error.dot(covariances.at(kNumKeyframes).position_m2.ldlt().solve(error));
    }

    double field_sigma_px_;
    synthetic::SensorRecording recording_;
    std::vector<types::ImuSample> exact_;
};

// Returns the mean over a hundred runs.
double mean_nees(double margin_s, double field_sigma_px) {
    NoisyDive dive(margin_s, field_sigma_px);
    double mean = 0.0;
    for (int run = 0; run < kNumRuns; ++run)
        mean += dive.nees(static_cast<std::uint32_t>(run + 1)) / kNumRuns;
    return mean;
}

// The 95 % interval of chi-square with 300 degrees of freedom, divided by 100.
constexpr double kMinNees = 2.539;
constexpr double kMaxNees = 3.499;

class PoseCovarianceTest : public testing::TestWithParam<double> {};

TEST_P(PoseCovarianceTest, IsAsLargeAsTheErrorsOfAHundredRuns) {
    const double mean = mean_nees(GetParam(), 0.0);
    EXPECT_GT(mean, kMinNees);
    EXPECT_LT(mean, kMaxNees);
}

INSTANTIATE_TEST_SUITE_P(SecondsOfImuBeyondTheFrames,
                         PoseCovarianceTest,
                         testing::Values(0.1, 0.006));

TEST(LensFieldTest, WhatLensesLeaveInTheImageIsInTheCovariance) {
    const double mean = mean_nees(0.1, 0.2);
    EXPECT_GT(mean, kMinNees);
    EXPECT_LT(mean, kMaxNees);
}

}  // namespace
}  // namespace divemesh::optimisation
