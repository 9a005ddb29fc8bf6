#include "worker/evaluation/scale_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <random>

#include "worker/base/seconds.hpp"

namespace divemesh::evaluation {
namespace {

constexpr double kDuration_s = 60.0;

Eigen::Vector3d position(double t) {
    return {0.3 * t + 0.1 * std::sin(2.1 * t), 0.15 * std::sin(1.3 * t), 0.8 * std::sin(0.4 * t)};
}
Eigen::Vector3d acceleration(double t) {
    return {-0.1 * 2.1 * 2.1 * std::sin(2.1 * t),
            -0.15 * 1.3 * 1.3 * std::sin(1.3 * t),
            -0.8 * 0.4 * 0.4 * std::sin(0.4 * t)};
}
Eigen::Matrix3d orientation(double t) {
    return (Eigen::AngleAxisd(0.3 * std::sin(0.5 * t), Eigen::Vector3d::UnitX()) *
            Eigen::AngleAxisd(0.2 * t, Eigen::Vector3d::UnitZ()))
        .toRotationMatrix();
}
Eigen::Vector3d rate_imu(double t) {
    const Eigen::AngleAxisd heading(0.2 * t, Eigen::Vector3d::UnitZ());
    return heading.inverse() * Eigen::Vector3d(0.3 * 0.5 * std::cos(0.5 * t), 0.0, 0.0) +
           Eigen::Vector3d(0.0, 0.0, 0.2);
}

// Returns the path by cameras that measure every length `shrunk` times as long as it is.
types::Trajectory path_seen(double shrunk,
                            double duration_s = kDuration_s,
                            double interval_s = 0.1) {
    types::Trajectory trajectory;
    for (int i = 0; i <= std::lround(duration_s / interval_s); ++i) {
        types::StampedPose pose{base::to_ns(interval_s * i), Eigen::Isometry3d::Identity()};
        pose.T_world_imu.linear() = orientation(interval_s * i);
        pose.T_world_imu.translation() = shrunk * position(interval_s * i);
        trajectory.push_back(pose);
    }
    return trajectory;
}

std::vector<types::ImuSample> imu_felt(double noise_m_s2, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, noise_m_s2);
    std::vector<types::ImuSample> imu;
    for (int i = 0; i <= 200 * static_cast<int>(kDuration_s); ++i) {
        const double t = 0.005 * i;
        types::ImuSample sample;
        sample.timestamp_ns = i * std::int64_t{5'000'000};
        sample.angular_velocity_imu = rate_imu(t) + Eigen::Vector3d(0.01, -0.02, 0.01);
        sample.acceleration_imu =
            orientation(t).transpose() * (acceleration(t) + Eigen::Vector3d(0.0, 0.0, 9.81)) +
            Eigen::Vector3d(0.05, -0.03, 0.08) +
            Eigen::Vector3d(noise(random), noise(random), noise(random));
        imu.push_back(sample);
    }
    return imu;
}

std::vector<types::PressureSample> depth_felt(double noise_m, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, noise_m);
    std::vector<types::PressureSample> pressure;
    for (int i = 0; i <= 10 * static_cast<int>(kDuration_s); ++i)
        pressure.push_back(
            {i * std::int64_t{100'000'000}, 7.0 - position(0.1 * i).z() + noise(random)});
    return pressure;
}

TEST(ScaleCheckTest, TheAccelerometerFindsAScaleErrorOfTheCameras) {
    const auto check = scale_by_accelerometer(imu_felt(0.03, 1), path_seen(0.97));
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0 / 0.97, 3.0 * check->sigma);
    EXPECT_LT(check->sigma, 0.01);
}

TEST(ScaleCheckTest, TheAccelerometerFindsItWithSlowFramesAsWell) {
    for (const double interval_s : {0.2, 0.4, 0.5}) {
        const auto check =
            scale_by_accelerometer(imu_felt(0.03, 1), path_seen(0.97, kDuration_s, interval_s));
        ASSERT_TRUE(check.has_value()) << interval_s;
        EXPECT_NEAR(check->scale, 1.0 / 0.97, 0.01) << interval_s;
        EXPECT_LT(check->sigma, 0.01) << interval_s;
    }
    EXPECT_FALSE(scale_by_accelerometer(imu_felt(0.03, 1), path_seen(0.97, kDuration_s, 0.75)));
}

// A body that rolls as it sways: frames 0.4 s apart miss 6 % of the roll, and gravity leaks into
// the sway.
TEST(ScaleCheckTest, TheGyroscopeTellsTheRotationBetweenSlowFrames) {
    const auto rolled = [](double t) {
        return Eigen::AngleAxisd(0.1 * std::sin(2.1 * t), Eigen::Vector3d::UnitX());
    };
    types::Trajectory trajectory;
    for (int i = 0; i <= 150; ++i) {
        types::StampedPose pose{i * std::int64_t{400'000'000}, Eigen::Isometry3d::Identity()};
        pose.T_world_imu.linear() = rolled(0.4 * i).toRotationMatrix();
        pose.T_world_imu.translation().y() = 0.15 * std::sin(2.1 * 0.4 * i);
        trajectory.push_back(pose);
    }
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0.0, 0.02);
    std::vector<types::ImuSample> imu;
    for (int i = 0; i <= 12'000; ++i) {
        const double t = 0.005 * i;
        const Eigen::Vector3d force(noise(random),
                                    -0.15 * 2.1 * 2.1 * std::sin(2.1 * t) + noise(random),
                                    9.81 + noise(random));
        imu.push_back({i * std::int64_t{5'000'000},
                       {0.1 * 2.1 * std::cos(2.1 * t), 0.0, 0.0},
                       rolled(t).inverse() * force});
    }
    const auto check = scale_by_accelerometer(imu, trajectory);
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0, 0.01);
    for (types::ImuSample& sample : imu) sample.angular_velocity_imu.setZero();
    EXPECT_LT(scale_by_accelerometer(imu, trajectory)->scale, 0.95);
}

// Returns the sum of the squared errors of forty runs, in sigmas.
double squared_sigmas(double noise_m_s2, double duration_s) {
    double sum = 0.0;
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        const auto check =
            scale_by_accelerometer(imu_felt(noise_m_s2, seed), path_seen(1.0, duration_s));
        if (!check) return 0.0;
        sum += std::pow((check->scale - 1.0) / check->sigma, 2.0);
    }
    return sum;
}

// The 99 % interval of chi-square with 40 degrees of freedom.
const auto kAsOfFortyNumbers = testing::AllOf(testing::Gt(20.7), testing::Lt(66.8));

TEST(ScaleCheckTest, ItsSigmaIsAsLargeAsTheErrorsOfFortyRuns) {
    EXPECT_THAT(squared_sigmas(0.1, kDuration_s), kAsOfFortyNumbers);
}

TEST(ScaleCheckTest, OfAShortDiveWithASmallNoiseAsWell) {
    EXPECT_THAT(squared_sigmas(0.02, 10.0), kAsOfFortyNumbers);
}

TEST(ScaleCheckTest, AGapOfTheImuCostsItsWindowsAlone) {
    std::vector<types::ImuSample> imu = imu_felt(0.03, 1);
    std::erase_if(imu, [](const types::ImuSample& sample) {
        return sample.timestamp_ns > 20'000'000'000 && sample.timestamp_ns < 25'000'000'000;
    });
    const auto check = scale_by_accelerometer(imu, path_seen(1.0));
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0, 3.0 * check->sigma);
    EXPECT_FALSE(scale_by_accelerometer({}, path_seen(1.0)).has_value());
}

TEST(ScaleCheckTest, ThePressureFindsAScaleErrorOfTheCameras) {
    const auto check = scale_by_pressure(depth_felt(0.02, 1), path_seen(0.95), 0.0);
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0 / 0.95, 3.0 * check->sigma);
    EXPECT_LT(check->sigma, 0.01);
    EXPECT_GT(scale_by_pressure(depth_felt(0.02, 1), path_seen(0.95), 0.05)->sigma, check->sigma);
    EXPECT_FALSE(scale_by_pressure({}, path_seen(1.0), 0.0).has_value());
}

TEST(ScaleCheckTest, MarkedDistancesCountByTheirSigmaAndTheTape) {
    KnownDistanceErrors errors;
    errors.distances.push_back({"not measured", 1.0, std::nullopt, std::nullopt, 2, 2});
    EXPECT_FALSE(scale_by_marked_distances(errors));
    errors.distances.push_back({"bar", 1.01, 1.0, 0.0015, 4, 4});
    const auto one = scale_by_marked_distances(errors);
    ASSERT_TRUE(one);
    EXPECT_NEAR(one->scale, 1.01, 1e-12);
    EXPECT_NEAR(one->sigma, 0.0025, 1e-12);  // 1.5 mm and 2 mm of 1 m
    errors.distances.push_back({"line", 10.1, 10.0, 0.015, 4, 4});
    const auto two = scale_by_marked_distances(errors);
    ASSERT_TRUE(two);
    EXPECT_NEAR(two->scale, 1.01, 1e-12);
    const double line = std::hypot(0.0015, 0.0002);
    EXPECT_NEAR(two->sigma, 0.0025 * line / std::hypot(0.0025, line), 1e-12);
    // One of them was typed wrong.
    errors.distances.push_back({"typed wrong", 1.51, 1.0, 0.0015, 4, 4});
    EXPECT_GT(scale_by_marked_distances(errors)->sigma, 0.1);
}

TEST(ScaleCheckTest, KnownDistancesSayTheScaleAndHowWellTheyAgree) {
    KnownDistanceErrors errors;
    for (const auto& [known, measured] : {std::pair(1.0, 0.981), {1.0, 0.979}, {2.0, 1.960}})
        errors.distances.push_back({"", known, measured, 4, 4});
    errors.num_measured = 3;
    errors.scale_error = -0.02;
    const auto check = scale_by_distances(errors, {});
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0 / 0.98, 1e-9);
    // Residuals of 1 mm, 1 mm and 0; the squares of the lengths sum to 6.
    EXPECT_NEAR(check->sigma, std::sqrt(2e-6 / 2.0 / 6.0), 1e-9);
    // The poses move ends that are 2 m apart by 3 mm, and those of the shorter lengths by 3 mm /
    // sqrt(2).
    const double by_poses = (2.0 * 0.003 / std::sqrt(2.0) + 2.0 * 0.003) / 6.0;
    EXPECT_NEAR(
        scale_by_distances(errors, {0.003, 2.0})->sigma, std::hypot(check->sigma, by_poses), 1e-9);
    errors.num_measured = 2;
    EXPECT_FALSE(scale_by_distances(errors, {}).has_value());
}

}  // namespace
}  // namespace divemesh::evaluation
