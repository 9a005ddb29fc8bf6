#include "worker/optimisation/frame_covariances.hpp"

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
constexpr double kMargin_s = 0.1;

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
    explicit NoisyDive(double field_sigma_px) : field_sigma_px_(field_sigma_px) {
        recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        exact_ = synthetic::imu_along(
            synthetic::T_world_imu_at, -kMargin_s, kDuration_s + kMargin_s, {});
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
        std::vector<types::Keyframe> keyframes;
        std::map<std::int64_t, types::Landmark> seen;
        for (int k = 0; k <= kNumKeyframes; ++k) {
            const int frame = kStep * k;
            const Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(frame);
            keyframes.push_back({frame, 100'000'000LL * frame, T_world_cam});
            if (k > 0) keyframes.back().T_world_cam.translation() += 0.005 * noise();
            for (types::Feature feature : world.see(T_world_cam, frame, 0.0)) {
                if (feature.id % kEveryNthPoint != 0) continue;
                const Eigen::Vector3d measured_px(
                    feature.pixel.x(), feature.pixel.y(), feature.disparity_px);
                const Eigen::Vector3d error = types::kFeatureSigma_px.cwiseProduct(noise()) +
                                              disparity_bias_px * Eigen::Vector3d::UnitZ() +
                                              by_field(synthetic::rig(), measured_px) * nodes_px;
                feature.pixel += error.head<2>();
                feature.disparity_px += error.z();
                const Eigen::Vector3d p =
                    keyframes.back().T_world_cam * types::point_cam(synthetic::rig(), feature);
                seen.try_emplace(feature.id, types::Landmark{p, {}})
                    .first->second.observations.push_back(
                        {k,
                         static_cast<float>(feature.pixel.x()),
                         static_cast<float>(feature.pixel.y()),
                         static_cast<float>(feature.disparity_px)});
            }
        }
        std::vector<types::Landmark> landmarks;
        for (auto& [id, landmark] : seen)
            if (landmark.observations.size() > 1) landmarks.push_back(std::move(landmark));
        types::RectifiedRig rig = synthetic::rig();
        rig.baseline_m *= 1.0 + kTriangulationSigma * normal(random);
        const GlobalBundleAdjustment adjusted = adjust_globally(rig,
                                                                imu::InertialPrior(recording_, {}),
                                                                keyframes,
                                                                landmarks,
                                                                {},
                                                                calibration(),
                                                                base::ignore_progress,
                                                                {});
        return normalised(rig, keyframes, adjusted.covariances);
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

TEST(PoseCovarianceTest, IsAsLargeAsTheErrorsOfAHundredRuns) {
    NoisyDive dive(0.0);
    double mean = 0.0;
    for (int run = 0; run < kNumRuns; ++run)
        mean += dive.nees(static_cast<std::uint32_t>(run + 1)) / kNumRuns;

    // The 95 % interval of chi-square with 300 degrees of freedom, divided by 100.
    EXPECT_GT(mean, 2.539);
    EXPECT_LT(mean, 3.499);
}

TEST(PoseCovarianceTest, HoldsWhatLensesLeaveInTheImage) {
    NoisyDive dive(0.2);
    double mean = 0.0;
    for (int run = 0; run < kNumRuns; ++run)
        mean += dive.nees(static_cast<std::uint32_t>(run + 1)) / kNumRuns;

    EXPECT_GT(mean, 2.539);
    EXPECT_LT(mean, 3.499);
}

// Eleven frames with keyframes at the first, the sixth and the eleventh. The odometry is off by
// `miss_m` to the side from the second keyframe on, and by twice that from the third.
struct Followed {
    explicit Followed(double miss_m) : odometry(11) {
        for (std::size_t i = 0; i < odometry.size(); ++i) {
            odometry[i].timestamp_ns = 100 * static_cast<std::int64_t>(i);
            odometry[i].T_world_imu.translation().x() = static_cast<double>(i);
            odometry[i].T_world_imu.translation().y() = i < 5 ? 0.0 : i < 10 ? miss_m : 2 * miss_m;
        }
        for (const std::int64_t i : {0, 5, 10}) {
            types::Keyframe keyframe;
            keyframe.timestamp_ns = 100 * i;
            keyframe.T_world_cam.translation().x() = static_cast<double>(i);
            keyframes.push_back(keyframe);
            covariances.push_back({100 * i,
                                   0.4 * static_cast<double>(i) * Eigen::Matrix3d::Identity(),
                                   Eigen::Matrix3d::Identity()});
        }
    }
    types::CovarianceTrack at_frames() const {
        return covariances_at(covariances, odometry, keyframes, Eigen::Isometry3d::Identity());
    }

    types::Trajectory odometry;
    std::vector<types::Keyframe> keyframes;
    types::CovarianceTrack covariances;
};

TEST(PoseCovarianceTest, OfFramesLiesBetweenThoseOfTheKeyframes) {
    const types::CovarianceTrack at = Followed(0.0).at_frames();
    ASSERT_EQ(at.size(), 11U);
    EXPECT_EQ(at[0].position_m2(0, 0), 0.0);
    EXPECT_NEAR(at[2].position_m2(0, 0), 0.8, 1e-12);
    EXPECT_NEAR(at[2].rotation_rad2(1, 1), 1.0, 1e-12);
    EXPECT_NEAR(at[10].position_m2(2, 2), 4.0, 1e-12);
}

TEST(PoseCovarianceTest, FramesBetweenKeyframesErrAsTheirOdometryDoes) {
    const types::CovarianceTrack at = Followed(0.3).at_frames();
    // Per axis 0.3^2 / 3 over five steps; the median of three values is below their mean.
    const double whole = 0.03 * 3.0 / 2.366;
    EXPECT_NEAR(at[2].position_m2(0, 0) - 0.8, 0.4 * 0.6 * whole, 1e-9);
    EXPECT_NEAR(at[5].position_m2(0, 0), 2.0, 1e-12);
}

}  // namespace
}  // namespace divemesh::optimisation
