#include "worker/imu/preintegration.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "tests/synthetic/inertial_motion.hpp"

namespace divemesh::imu {
namespace {

constexpr std::int64_t kFrom_ns = 203'000'000;
constexpr std::int64_t kTo_ns = 703'000'000;
using Vector9 = Eigen::Matrix<double, 9, 1>;

// Returns a pose on a lively path: half a metre and half a radian back and forth within seconds.
Eigen::Isometry3d lively(double t_s) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << 0.3 * t_s + 0.2 * std::sin(2.0 * t_s), 0.5 * std::sin(1.5 * t_s),
        0.2 * std::cos(3.0 * t_s);
    T.linear() = base::rotation_from_vector({0.4 * std::sin(2.0 * t_s),
                                             0.5 * std::sin(1.3 * t_s + 0.4),
                                             0.6 * t_s + 0.3 * std::cos(1.7 * t_s)})
                     .toRotationMatrix();
    return T;
}

PreintegratedImu integrated(const std::vector<types::ImuSample>& samples, const ImuBias& bias) {
    const auto result = preintegrate(samples, kFrom_ns, kTo_ns, bias, types::ImuNoise{});
    EXPECT_TRUE(std::holds_alternative<PreintegratedImu>(result));
    return std::get<PreintegratedImu>(result);
}

// Returns the differences between `a` and `b` in rotation, velocity and position.
Vector9 difference(const PreintegratedImu& a, const PreintegratedImu& b) {
    Vector9 result;
    result << base::vector_from_rotation(b.rotation.q_from_to.conjugate() * a.rotation.q_from_to),
        a.delta_velocity - b.delta_velocity, a.delta_position - b.delta_position;
    return result;
}

PreintegratedImu truth() {
    const double from_s = 1e-9 * kFrom_ns;
    const double dt = 1e-9 * (kTo_ns - kFrom_ns);
    const Eigen::Isometry3d i = lively(from_s);
    const Eigen::Isometry3d j = lively(from_s + dt);
    const Eigen::Vector3d g(0.0, 0.0, -kGravity_m_s2);
    const Eigen::Vector3d v_i = synthetic::velocity(lively, from_s);
    const Eigen::Vector3d v_j = synthetic::velocity(lively, from_s + dt);
    PreintegratedImu result;
    result.rotation.q_from_to = Eigen::Quaterniond(i.linear().transpose() * j.linear());
    result.delta_velocity = i.linear().transpose() * (v_j - v_i - g * dt);
    result.delta_position =
        i.linear().transpose() * (j.translation() - i.translation() - v_i * dt - 0.5 * g * dt * dt);
    return result;
}

TEST(PreintegrationTest, GivesTheMotionBetweenTwoTimesToTheSecondOrderOfTheSampleInterval) {
    const ImuBias bias{{0.01, -0.02, 0.015}, {0.1, -0.05, 0.07}};
    const auto coarse = integrated(synthetic::imu_along(lively, 0.0, 1.0, bias), bias);
    const auto fine = integrated(synthetic::imu_along(lively, 0.0, 1.0, bias, 2000.0), bias);

    EXPECT_LT(difference(coarse, truth()).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_LT(difference(fine, truth()).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_DOUBLE_EQ(coarse.rotation.duration_s, 0.5);
}

TEST(PreintegrationTest, GoesByTheStampsWhereSamplesAreMissing) {
    auto samples = synthetic::imu_along(lively, 0.0, 1.0, {}, 400.0);
    std::mt19937 random(3);
    std::erase_if(samples, [&](const types::ImuSample& sample) {
        return sample.timestamp_ns > 0 && sample.timestamp_ns < 900'000'000 && random() % 3 == 0;
    });

    EXPECT_LT(difference(integrated(samples, {}), truth()).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(PreintegrationTest, ItsDerivativesByTheBiasesAreThoseOfIntegratingAgain) {
    const auto samples = synthetic::imu_along(lively, 0.0, 1.0, {});
    const auto at_zero = integrated(samples, {});
    Eigen::Matrix<double, 9, 6> stated = Eigen::Matrix<double, 9, 6>::Zero();
    stated << at_zero.rotation.d_rotation_d_bias, Eigen::Matrix3d::Zero(),
        at_zero.d_velocity_d_gyroscope, at_zero.d_velocity_d_accelerometer,
        at_zero.d_position_d_gyroscope, at_zero.d_position_d_accelerometer;

    for (int axis = 0; axis < 6; ++axis) {
        constexpr double kStep = 1e-4;
        ImuBias above;
        ImuBias below;
        (axis < 3 ? above.gyroscope : above.accelerometer)[axis % 3] = kStep;
        (axis < 3 ? below.gyroscope : below.accelerometer)[axis % 3] = -kStep;
        const Vector9 numeric =
            difference(integrated(samples, above), integrated(samples, below)) / (2.0 * kStep);
        EXPECT_LT((stated.col(axis) - numeric).norm(), 1e-6) << "axis " << axis;
    }
}

TEST(PreintegrationTest, ItsCovarianceIsTheSpreadOfNoisyIntegrals) {
    const auto exact = synthetic::imu_along(lively, 0.0, 1.0, {});
    const types::ImuNoise noise;
    const auto clean = integrated(exact, {});
    const Eigen::LLT<PreintegratedImu::Covariance> factor(clean.covariance);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto three = [&] {
        return Eigen::Vector3d(normal(random), normal(random), normal(random));
    };
    constexpr int kNumRuns = 500;
    double squared_mahalanobis = 0.0;
    Vector9 squares = Vector9::Zero();
    for (int run = 0; run < kNumRuns; ++run) {
        auto samples = exact;
        for (types::ImuSample& sample : samples) {
            sample.angular_velocity_imu +=
                noise.gyroscope_noise_density * std::sqrt(200.0) * three();
            sample.acceleration_imu +=
                noise.accelerometer_noise_density * std::sqrt(200.0) * three();
        }
        const Vector9 error = difference(integrated(samples, {}), clean);
        squared_mahalanobis += error.dot(factor.solve(error));
        squares += error.cwiseAbs2();
    }

    // Chi-square with 9 * 500 degrees of freedom, 4 sigma on either side.
    EXPECT_NEAR(squared_mahalanobis / kNumRuns, 9.0, 4.0 * std::sqrt(18.0 / kNumRuns));
    for (int i = 0; i < 9; ++i)
        EXPECT_NEAR(squares[i] / kNumRuns / clean.covariance(i, i), 1.0, 0.25) << i;
}

// White noise of density s moves the velocity by s^2 dt and the position by s^2 dt^3 / 3.
TEST(PreintegrationTest, ASingleStepHasTheCovarianceOfWhiteNoise) {
    const auto samples = synthetic::imu_along(lively, 0.0, 1.0, {});
    const types::ImuNoise noise;
    const auto result = preintegrate(samples, 201'000'000, 204'000'000, {}, noise);
    const auto& covariance = std::get<PreintegratedImu>(result).covariance;
    constexpr double kDt_s = 0.003;
    const double density = noise.accelerometer_noise_density;
    EXPECT_NEAR(covariance(3, 3) / (density * density * kDt_s), 1.0, 1e-3);
    EXPECT_NEAR(covariance(6, 6) / (density * density * kDt_s * kDt_s * kDt_s / 3.0), 1.0, 1e-3);
    // The correlation of velocity and position is sqrt(3) / 2.
    const double correlation = covariance(3, 6) / std::sqrt(covariance(3, 3) * covariance(6, 6));
    EXPECT_NEAR(correlation, 0.5 * std::sqrt(3.0), 1e-3);
    EXPECT_EQ(covariance.llt().info(), Eigen::Success);
}

TEST(PreintegrationTest, SaysWhyItRefuses) {
    auto samples = synthetic::imu_along(lively, 0.0, 1.0, {});
    const auto refusal = [&](std::int64_t from_ns, std::int64_t to_ns) {
        return std::get<ImuFailure>(preintegrate(samples, from_ns, to_ns, {}, types::ImuNoise{}));
    };
    EXPECT_EQ(refusal(-1, 100), ImuFailure::NotCovered);
    EXPECT_EQ(refusal(0, 1'000'000'001), ImuFailure::NotCovered);
    EXPECT_EQ(refusal(100, 100), ImuFailure::NotCovered);
    samples.erase(samples.begin() + 50, samples.begin() + 80);
    EXPECT_EQ(refusal(0, 900'000'000), ImuFailure::Gap);
}

}  // namespace
}  // namespace divemesh::imu
