#include "worker/simulator/inertial_sensors.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace divemesh::simulator {
namespace {

// Integrates by the midpoint rule from the state at the first sample.
double position_error_after_integration_m(const std::vector<ImuRecord>& records) {
    Eigen::Quaterniond q_world_imu(records.front().truth.T_world_imu.linear());
    Eigen::Vector3d position = records.front().truth.T_world_imu.translation();
    Eigen::Vector3d velocity = records.front().truth.velocity_world;
    const double dt_s = 1.0 / kImuRateHz;
    for (std::size_t i = 0; i + 1 < records.size(); ++i) {
        const types::ImuSample& a = records[i].sample;
        const types::ImuSample& b = records[i + 1].sample;
        const Eigen::Vector3d rotation =
            0.5 * dt_s * (a.angular_velocity_imu + b.angular_velocity_imu);
        const Eigen::Quaterniond q_next =
            q_world_imu *
            Eigen::Quaterniond(Eigen::AngleAxisd(rotation.norm(), rotation.normalized()));
        const Eigen::Vector3d acceleration =
            0.5 * (q_world_imu * a.acceleration_imu + q_next * b.acceleration_imu) -
            Eigen::Vector3d(0.0, 0.0, kGravity);
        position += velocity * dt_s + 0.5 * dt_s * dt_s * acceleration;
        velocity += dt_s * acceleration;
        q_world_imu = q_next.normalized();
    }
    return (position - records.back().truth.T_world_imu.translation()).norm();
}

TEST(InertialSensorsTest, IntegratingTheExactImuForTenSecondsReturnsToTheTruth) {
    const auto motion = DiverMotion::open_path({}, 3.0, 5);
    const auto records = simulate_imu(motion, 9.0, nullptr, 5);
    ASSERT_NEAR(static_cast<double>(records.size()) / kImuRateHz, 10.0, 0.02);
    EXPECT_LT(position_error_after_integration_m(records), 0.002);
}

TEST(InertialSensorsTest, NoiseHasTheDensityThatIsStated) {
    const auto motion = DiverMotion::open_path({}, 20.0, 5);
    const types::ImuNoise noise{.gyroscope_noise_density = 2e-4,
                                .accelerometer_noise_density = 2e-3};
    const auto exact = simulate_imu(motion, 60.0, nullptr, 5);
    const auto noisy = simulate_imu(motion, 60.0, &noise, 5);
    double gyroscope = 0.0;
    double accelerometer = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        gyroscope += (noisy[i].sample.angular_velocity_imu - noisy[i].gyroscope_bias -
                      exact[i].sample.angular_velocity_imu)
                         .squaredNorm();
        accelerometer += (noisy[i].sample.acceleration_imu - noisy[i].accelerometer_bias -
                          exact[i].sample.acceleration_imu)
                             .squaredNorm();
    }
    const double count = 3.0 * static_cast<double>(exact.size());
    EXPECT_NEAR(std::sqrt(gyroscope / count), 2e-4 * std::sqrt(kImuRateHz), 0.03 * 2.9e-3);
    EXPECT_NEAR(std::sqrt(accelerometer / count), 2e-3 * std::sqrt(kImuRateHz), 0.03 * 2.9e-2);
}

TEST(InertialSensorsTest, SamplesReachHalfASecondBeyondTheFrames) {
    const auto motion = DiverMotion::open_path({}, 1.0, 5);
    const auto records = simulate_imu(motion, 3.0, nullptr, 5);
    EXPECT_LE(records.front().sample.timestamp_ns, kFirstFrame_ns - 500'000'000);
    EXPECT_GE(records.back().sample.timestamp_ns, kFirstFrame_ns + 3'500'000'000);
}

TEST(InertialSensorsTest, OrientationIsWrongByAThirdToHalfADegree) {
    const auto motion = DiverMotion::open_path({}, 40.0, 5);
    double sum = 0.0;
    const auto samples = simulate_ahrs(motion, 150.0, true, 5);
    for (const types::OrientationSample& sample : samples) {
        const double t_s = static_cast<double>(sample.timestamp_ns - kFirstFrame_ns) * 1e-9;
        const Eigen::Quaterniond truth(motion.at(t_s).T_world_imu.linear());
        sum += std::pow(truth.angularDistance(sample.q_world_imu), 2);
    }
    const double rms_deg =
        std::sqrt(sum / static_cast<double>(samples.size())) * 180.0 / std::numbers::pi;
    EXPECT_GT(rms_deg, 0.25);
    EXPECT_LT(rms_deg, 0.55);
}

TEST(InertialSensorsTest, DepthIsCountedDownwardsFromTheSurface) {
    const auto motion = DiverMotion::open_path({}, 1.0, 5);
    const auto samples = simulate_pressure(motion, 2.0, 9.0, false, 5);
    ASSERT_FALSE(samples.empty());
    for (const types::PressureSample& sample : samples) {
        const double t_s = static_cast<double>(sample.timestamp_ns - kFirstFrame_ns) * 1e-9;
        EXPECT_NEAR(sample.depth_m, 9.0 - motion.at(t_s).T_world_imu.translation().z(), 1e-6);
    }
}

}  // namespace
}  // namespace divemesh::simulator
