#include "worker/evaluation/scale_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/worker/evaluation/turning_sway.hpp"

namespace divemesh::evaluation {
namespace {

std::vector<types::PressureSample> depth_felt(double noise_m, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, noise_m);
    std::vector<types::PressureSample> pressure;
    for (int i = 0; i <= 10 * static_cast<int>(kDuration_s); ++i)
        pressure.push_back(
            {i * std::int64_t{100'000'000}, 7.0 - position(0.1 * i).z() + noise(random)});
    return pressure;
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
