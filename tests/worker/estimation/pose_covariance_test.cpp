#include "worker/estimation/pose_covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <map>
#include <random>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "worker/estimation/global_adjustment.hpp"

namespace divemesh::worker {
namespace {

constexpr int kNumRuns = 100;
constexpr int kNumKeyframes = 8;
constexpr int kStep = 5;  // frames of 0.1 s from keyframe to keyframe
constexpr double kDuration_s = 0.1 * kStep * kNumKeyframes;
constexpr std::int64_t kEveryNthPoint = 5;

// The way of stereo_world.hpp with features, gyroscope and accelerometer as noisy as the adjustment
// takes them to be; no pictures.
class NoisyDive {
public:
    NoisyDive() {
        recording_.its_rig.imu_noise = ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        exact_ = synthetic::imu_along(synthetic::T_world_imu_at, 0.0, kDuration_s, {});
    }

    // Normalised error of the last position relative to the first pose, squared.
    double nees(std::uint32_t seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        const auto noise = [&] {
            return Eigen::Vector3d(normal(random), normal(random), normal(random));
        };
        recording_.its_imu = exact_;
        const ImuNoise sigma = InertialPrior(recording_, {}).noise();
        const double root_rate = std::sqrt(200.0);
        const Eigen::Vector3d gyroscope_bias = 0.005 * noise();
        const Eigen::Vector3d accelerometer_bias = 0.05 * noise();
        for (ImuSample& sample : recording_.its_imu) {
            sample.angular_velocity_imu +=
                gyroscope_bias + sigma.gyroscope_noise_density * root_rate * noise();
            sample.acceleration_imu +=
                accelerometer_bias + sigma.accelerometer_noise_density * root_rate * noise();
        }
        synthetic::World world(0.03 * kStep * kNumKeyframes, 0.0, seed);
        std::vector<Keyframe> keyframes;
        std::map<std::int64_t, Landmark> seen;
        for (int k = 0; k <= kNumKeyframes; ++k) {
            const int frame = kStep * k;
            const Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(frame);
            keyframes.push_back({frame, 100'000'000LL * frame, T_world_cam});
            if (k > 0) keyframes.back().T_world_cam.translation() += 0.005 * noise();
            for (Feature feature : world.see(T_world_cam, frame, 0.0)) {
                if (feature.id % kEveryNthPoint != 0) continue;
                const Eigen::Vector3d error = kFeatureSigma_px.cwiseProduct(noise());
                feature.pixel += error.head<2>();
                feature.disparity_px += error.z();
                const Eigen::Vector3d p =
                    keyframes.back().T_world_cam * point_cam(synthetic::rig(), feature);
                seen.try_emplace(feature.id, Landmark{p, {}})
                    .first->second.observations.push_back(
                        {k,
                         static_cast<float>(feature.pixel.x()),
                         static_cast<float>(feature.pixel.y()),
                         static_cast<float>(feature.disparity_px)});
            }
        }
        std::vector<Landmark> landmarks;
        for (auto& [id, landmark] : seen)
            if (landmark.observations.size() > 1) landmarks.push_back(std::move(landmark));
        const RectifiedRig rig = synthetic::rig();
        const AdjustedDive adjusted = adjust_dive(
            rig, InertialPrior(recording_, {}), keyframes, landmarks, ignore_progress, {});
        return normalised(rig, keyframes, adjusted.covariances);
    }

private:
    static double normalised(const RectifiedRig& rig,
                             const std::vector<Keyframe>& keyframes,
                             const CovarianceTrack& covariances) {
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

    synthetic::SensorRecording recording_;
    std::vector<ImuSample> exact_;
};

TEST(PoseCovarianceTest, IsAsLargeAsTheErrorsOfAHundredRuns) {
    NoisyDive dive;
    double mean = 0.0;
    for (int run = 0; run < kNumRuns; ++run)
        mean += dive.nees(static_cast<std::uint32_t>(run + 1)) / kNumRuns;

    // 95 % of chi-square with 300 degrees of freedom, over 100.
    EXPECT_GT(mean, 2.539);
    EXPECT_LT(mean, 3.499);
}

TEST(PoseCovarianceTest, OfFramesLiesBetweenThoseOfTheKeyframes) {
    const CovarianceTrack keyframes = {
        {100, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()},
        {200, 4.0 * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()}};
    Trajectory frames(4);
    for (std::size_t i = 0; i < frames.size(); ++i)
        frames[i].timestamp_ns = 50 + 75 * static_cast<std::int64_t>(i);

    const CovarianceTrack at = covariances_at(keyframes, frames);

    ASSERT_EQ(at.size(), 4U);
    EXPECT_EQ(at[0].position_m2(0, 0), 0.0);
    EXPECT_DOUBLE_EQ(at[1].position_m2(0, 0), 1.0);
    EXPECT_DOUBLE_EQ(at[2].rotation_rad2(1, 1), 1.0);
    EXPECT_DOUBLE_EQ(at[3].position_m2(2, 2), 4.0);
}

}  // namespace
}  // namespace divemesh::worker
