#include "worker/evaluation/accelerometer_fit.hpp"

#include <gtest/gtest.h>

#include <gmock/gmock.h>

#include "tests/worker/evaluation/turning_sway.hpp"

namespace divemesh::evaluation {
namespace {

TEST(AccelerometerFitTest, FindsAScaleErrorOfTheCameras) {
    const auto check = scale_by_accelerometer(imu_felt(0.03, 1), path_seen(0.97));
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0 / 0.97, 3.0 * check->sigma);
    EXPECT_LT(check->sigma, 0.01);
}

TEST(AccelerometerFitTest, FindsItWithSlowFramesAsWell) {
    for (const double interval_s : {0.2, 0.4, 0.5}) {
        const auto check =
            scale_by_accelerometer(imu_felt(0.03, 1), path_seen(0.97, kDuration_s, interval_s));
        ASSERT_TRUE(check.has_value()) << interval_s;
        EXPECT_NEAR(check->scale, 1.0 / 0.97, 0.01) << interval_s;
        EXPECT_LT(check->sigma, 0.01) << interval_s;
    }
    EXPECT_FALSE(scale_by_accelerometer(imu_felt(0.03, 1), path_seen(0.97, kDuration_s, 0.75)));
}

// A body that rolls as it sways: frames 0.4 s apart alone would miss 6 % of the roll, and gravity
// would leak into the sway. A slower sway without roll tells the sway from a bias that rolls.
TEST(AccelerometerFitTest, TheGyroscopeTellsTheRotationBetweenSlowFrames) {
    const auto rolled = [](double t) {
        return Eigen::AngleAxisd(0.1 * std::sin(2.1 * t), Eigen::Vector3d::UnitX());
    };
    types::Trajectory trajectory;
    for (int i = 0; i <= 150; ++i) {
        types::StampedPose pose{i * std::int64_t{400'000'000}, Eigen::Isometry3d::Identity()};
        pose.T_world_imu.linear() = rolled(0.4 * i).toRotationMatrix();
        pose.T_world_imu.translation().y() =
            0.15 * std::sin(2.1 * 0.4 * i) + 0.3 * std::sin(0.4 * i);
        trajectory.push_back(pose);
    }
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0.0, 0.02);
    std::vector<types::ImuSample> imu;
    for (int i = 0; i <= 12'000; ++i) {
        const double t = 0.005 * i;
        const Eigen::Vector3d force(
            noise(random),
            -0.15 * 2.1 * 2.1 * std::sin(2.1 * t) - 0.3 * std::sin(t) + noise(random),
            9.81 + noise(random));
        imu.push_back({i * std::int64_t{5'000'000},
                       {0.1 * 2.1 * std::cos(2.1 * t), 0.0, 0.0},
                       rolled(t).inverse() * force});
    }
    const auto check = scale_by_accelerometer(imu, trajectory);
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0, 0.01);
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

TEST(AccelerometerFitTest, ItsSigmaIsAsLargeAsTheErrorsOfFortyRuns) {
    EXPECT_THAT(squared_sigmas(0.1, kDuration_s), kAsOfFortyNumbers);
}

TEST(AccelerometerFitTest, OfAShortDiveWithASmallNoiseAsWell) {
    EXPECT_THAT(squared_sigmas(0.02, 10.0), kAsOfFortyNumbers);
}

// A rig that rests for 50 s, where its path is exact, and then swings for ten.
TEST(AccelerometerFitTest, ARestDoesNotMakeTheScaleLookCertain) {
    constexpr double kRest_s = 50.0;
    const Eigen::Vector3d size_m(0.3, 0.2, 0.1);
    const Eigen::Vector3d rate(1.3, 2.1, 0.9);
    double sum = 0.0;
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        const auto three = [&] {
            return Eigen::Vector3d(normal(random), normal(random), normal(random));
        };
        types::Trajectory path;
        for (int i = 0; i <= 600; ++i) {
            const double t = std::max(0.0, 0.1 * i - kRest_s);
            types::StampedPose pose{base::to_ns(0.1 * i), Eigen::Isometry3d::Identity()};
            if (t > 0.0)
                pose.T_world_imu.translation() =
                    size_m.array() * (1.0 - (rate * t).array().cos()) + 0.01 * three().array();
            path.push_back(pose);
        }
        std::vector<types::ImuSample> imu;
        for (int i = 0; i <= 12'000; ++i) {
            const double t = 0.005 * i - kRest_s;
            Eigen::Vector3d force(0.05, -0.03, 9.81 + 0.08);
            if (t > 0.0)
                force.array() += size_m.array() * rate.array().square() * (rate * t).array().cos();
            imu.push_back(
                {i * std::int64_t{5'000'000}, Eigen::Vector3d::Zero(), force + 0.03 * three()});
        }
        const auto check = scale_by_accelerometer(imu, path);
        ASSERT_TRUE(check.has_value());
        sum += std::pow((check->scale - 1.0) / check->sigma, 2.0);
    }
    EXPECT_THAT(sum, kAsOfFortyNumbers);  // 238 with equal variances
}

TEST(AccelerometerFitTest, AGapOfTheImuCostsItsWindowsAlone) {
    std::vector<types::ImuSample> imu = imu_felt(0.03, 1);
    std::erase_if(imu, [](const types::ImuSample& sample) {
        return sample.timestamp_ns > 20'000'000'000 && sample.timestamp_ns < 25'000'000'000;
    });
    const auto check = scale_by_accelerometer(imu, path_seen(1.0));
    ASSERT_TRUE(check.has_value());
    EXPECT_NEAR(check->scale, 1.0, 3.0 * check->sigma);
    EXPECT_FALSE(scale_by_accelerometer({}, path_seen(1.0)).has_value());
}

TEST(AccelerometerFitTest, FindsWhereTheAccelerometerIs) {
    const Eigen::Vector3d arm_m(0.12, -0.08, 0.05);
    const auto fit = fit_accelerometer(imu_felt(0.03, 1, arm_m), path_seen(0.97));
    ASSERT_TRUE(fit.has_value());
    const Eigen::Vector3d error_m = fit->lever_arm_m - 0.97 * arm_m;  // in lengths of the path
    EXPECT_LT(error_m.norm(), 0.02);
    EXPECT_LT(error_m.dot(fit->lever_arm_covariance_m2.inverse() * error_m), 16.0);
    EXPECT_NEAR(fit->scale.scale, 1.0 / 0.97, 3.0 * fit->scale.sigma);
}

// The accelerations of an arm of 17 cm look like another scale.
TEST(AccelerometerFitTest, AnArmThatIsNotStatedLeavesTheScaleRight) {
    double sum = 0.0;
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        const auto fit = fit_accelerometer(imu_felt(0.1, seed, {0.1, 0.1, 0.1}), path_seen(1.0));
        ASSERT_TRUE(fit.has_value());
        sum += std::pow((fit->scale.scale - 1.0) / fit->scale.sigma, 2.0);
    }
    EXPECT_THAT(sum, kAsOfFortyNumbers);
}

TEST(AccelerometerFitTest, AxesThatAreNotTheGyroscopesLeaveTheScaleRight) {
    std::vector<types::ImuSample> imu = imu_felt(0.03, 1);
    const Eigen::AngleAxisd turned(0.008, Eigen::Vector3d(1.0, 2.0, -1.0).normalized());
    for (types::ImuSample& sample : imu) sample.acceleration_imu = turned * sample.acceleration_imu;
    const auto fit = fit_accelerometer(imu, path_seen(1.0));
    ASSERT_TRUE(fit.has_value());
    EXPECT_NEAR(fit->scale.scale, 1.0, 3.0 * fit->scale.sigma);
    EXPECT_LT(fit->scale.sigma, 0.01);
}

TEST(AccelerometerFitTest, WithoutRotationTheArmIsNotKnown) {
    types::Trajectory trajectory = path_seen(1.0);
    for (types::StampedPose& pose : trajectory) pose.T_world_imu.linear().setIdentity();
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0.0, 0.03);
    std::vector<types::ImuSample> imu;
    for (int i = 0; i <= 200 * static_cast<int>(kDuration_s); ++i)
        imu.push_back({i * std::int64_t{5'000'000},
                       Eigen::Vector3d::Zero(),
                       acceleration(0.005 * i) +
                           Eigen::Vector3d(noise(random), noise(random), 9.81 + noise(random))});
    const auto fit = fit_accelerometer(imu, trajectory);
    ASSERT_TRUE(fit.has_value());
    EXPECT_LT(fit->lever_arm_m.norm(), 1e-3);
    EXPECT_NEAR(std::sqrt(fit->lever_arm_covariance_m2(0, 0)), 0.05, 1e-3);
}

}  // namespace
}  // namespace divemesh::evaluation
