#include "worker/imu/measured_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace divemesh::imu {
namespace {

constexpr types::ImuNoise kStated{.gyroscope_noise_density = 2e-4,
                                  .accelerometer_noise_density = 2e-3};

// Returns 20 s of a diver's swaying motion, and white noise of these densities.
std::vector<types::ImuSample> swaying(double rate_hz, const types::ImuNoise& noise) {
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    const auto white = [&](double density) {
        return Eigen::Vector3d(density * std::sqrt(rate_hz) *
                               Eigen::Vector3d(normal(random), normal(random), normal(random)));
    };
    std::vector<types::ImuSample> samples;
    for (int i = 0; i < static_cast<int>(20.0 * rate_hz); ++i) {
        const double t = i / rate_hz;
        types::ImuSample sample;
        sample.timestamp_ns = std::llround(1e9 * t);
        sample.angular_velocity_imu =
            Eigen::Vector3d(0.3 * std::sin(2.0 * t), 0.2 * std::cos(1.3 * t), 0.1) +
            white(noise.gyroscope_noise_density);
        sample.acceleration_imu =
            Eigen::Vector3d(0.5 * std::sin(1.7 * t), 0.3 * std::sin(2.9 * t), 9.81) +
            white(noise.accelerometer_noise_density);
        samples.push_back(sample);
    }
    return samples;
}

TEST(MeasuredNoiseTest, ASensorAsGoodAsStatedStaysAsStated) {
    types::ImuNoise better = kStated;
    better.gyroscope_noise_density *= 0.5;
    better.accelerometer_noise_density *= 0.5;
    const types::ImuNoise noise = at_least_measured(swaying(200.0, better), kStated);
    EXPECT_EQ(noise.gyroscope_noise_density, kStated.gyroscope_noise_density);
    EXPECT_EQ(noise.accelerometer_noise_density, kStated.accelerometer_noise_density);
}

TEST(MeasuredNoiseTest, FindsTheDensityOfWhiteNoise) {
    for (const double times : {3.0, 30.0, 300.0}) {
        types::ImuNoise worse = kStated;
        worse.gyroscope_noise_density *= times;
        worse.accelerometer_noise_density *= times;
        const types::ImuNoise noise = at_least_measured(swaying(200.0, worse), kStated);
        EXPECT_NEAR(noise.gyroscope_noise_density / worse.gyroscope_noise_density, 1.0, 0.1);
        EXPECT_NEAR(
            noise.accelerometer_noise_density / worse.accelerometer_noise_density, 1.0, 0.1);
    }
}

TEST(MeasuredNoiseTest, AStepNowAndThenIsNoNoise) {
    std::vector<types::ImuSample> samples = swaying(200.0, kStated);
    for (std::size_t i = 900; i < samples.size(); i += 900)
        samples[i].angular_velocity_imu.x() += 1.0;
    const types::ImuNoise noise = at_least_measured(samples, kStated);
    EXPECT_LT(noise.gyroscope_noise_density, 1.1 * kStated.gyroscope_noise_density);
}

TEST(MeasuredNoiseTest, ASensorTooSlowForTheMotionCountsAsNoisy) {
    const types::ImuNoise noise = at_least_measured(swaying(10.0, kStated), kStated);
    EXPECT_GT(noise.gyroscope_noise_density, 3.0 * kStated.gyroscope_noise_density);
}

TEST(MeasuredNoiseTest, UnevenIntervalsAreNoNoise) {
    std::vector<types::ImuSample> samples = swaying(100.0, {});
    for (std::size_t i = 0; i < samples.size(); ++i) {  // 2 and 18 ms in turn, and a gap
        const double t =
            0.01 * static_cast<double>(i) - (i % 2 == 1 ? 0.008 : 0.0) + (i > 1000 ? 3.0 : 0.0);
        samples[i].timestamp_ns = std::llround(1e9 * t);
        samples[i].angular_velocity_imu = {0.3 * std::sin(2.0 * t), 0.2 * std::cos(1.3 * t), 0.1};
    }
    const types::ImuNoise noise = at_least_measured(samples, kStated);
    EXPECT_EQ(noise.gyroscope_noise_density, kStated.gyroscope_noise_density);
}

TEST(MeasuredNoiseTest, FewSamplesShowNothing) {
    EXPECT_EQ(at_least_measured({}, kStated).gyroscope_noise_density,
              kStated.gyroscope_noise_density);
    auto few = swaying(200.0, {.gyroscope_noise_density = 1.0, .accelerometer_noise_density = 1.0});
    few.resize(20);
    EXPECT_EQ(at_least_measured(few, kStated).accelerometer_noise_density,
              kStated.accelerometer_noise_density);
}

}  // namespace
}  // namespace divemesh::imu
