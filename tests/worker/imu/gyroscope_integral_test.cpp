#include "worker/imu/gyroscope_integral.hpp"

#include <gtest/gtest.h>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::imu {
namespace {

const Eigen::Vector3d kRate(0.3, -0.5, 0.8);

std::vector<types::ImuSample> turning(const Eigen::Vector3d& bias) {
    std::vector<types::ImuSample> samples;
    for (int i = 0; i <= 200; ++i) {
        types::ImuSample sample;
        sample.timestamp_ns = 5'000'000LL * i;
        sample.angular_velocity_imu = kRate + bias;
        samples.push_back(sample);
    }
    return samples;
}

TEST(GyroscopeIntegralTest, GivesTheTurnOfAConstantRateBetweenAnyTwoTimes) {
    const auto integral = integrate_gyroscope(
        turning(Eigen::Vector3d::Zero()), 101'000'000, 803'000'000, Eigen::Vector3d::Zero(), {});

    ASSERT_TRUE(integral);
    const Eigen::Quaterniond expected = base::rotation_from_vector(kRate * 0.702);
    EXPECT_LT(integral->q_from_to.angularDistance(expected), 1e-9);
    EXPECT_DOUBLE_EQ(integral->duration_s, 0.702);
}

TEST(GyroscopeIntegralTest, FollowsAChangeOfBiasWithoutIntegratingAgain) {
    const Eigen::Vector3d bias(0.01, -0.02, 0.015);
    const auto samples = turning(bias);
    const auto integral = integrate_gyroscope(samples, 0, 500'000'000, Eigen::Vector3d::Zero(), {});

    ASSERT_TRUE(integral);
    const Eigen::Quaterniond expected = base::rotation_from_vector(kRate * 0.5);
    EXPECT_GT(integral->q_from_to.angularDistance(expected), 0.01);
    EXPECT_LT(integral->rotation(bias).angularDistance(expected), 1e-4);
}

TEST(GyroscopeIntegralTest, RefusesGapsAndTimesItDoesNotCover) {
    auto samples = turning(Eigen::Vector3d::Zero());
    EXPECT_FALSE(integrate_gyroscope(samples, -1, 100, Eigen::Vector3d::Zero(), {}));
    EXPECT_FALSE(integrate_gyroscope(samples, 0, 1'000'000'001, Eigen::Vector3d::Zero(), {}));
    samples.erase(samples.begin() + 50, samples.begin() + 80);
    EXPECT_FALSE(integrate_gyroscope(samples, 0, 900'000'000, Eigen::Vector3d::Zero(), {}));
    EXPECT_TRUE(integrate_gyroscope(samples, 0, 200'000'000, Eigen::Vector3d::Zero(), {}));
}

}  // namespace
}  // namespace divemesh::imu
