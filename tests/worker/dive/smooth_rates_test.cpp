#include "worker/dive/smooth_rates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace divemesh::dive {
namespace {

// The rate of a point's row under a camera's motion (Longuet-Higgins and Prazdny 1980), px/s.
double rate_px_s(const EpipolarSample& s) {
    constexpr double kFocal_px = 300.0;
    const Eigen::Vector3d velocity(0.2, -0.1, 0.15);    // m/s
    const Eigen::Vector3d rotation(0.05, 0.02, -0.04);  // rad/s
    const double x = s.ray.x();
    const double y = s.ray.y();
    return kFocal_px * (s.inverse_depth_1_m * (-velocity.y() + y * velocity.z()) +
                        rotation.x() * (1.0 + y * y) - rotation.y() * x * y - rotation.z() * x);
}

// Returns samples in random places with the noise of tracking, a part of them on fish.
std::vector<EpipolarSample> samples(std::size_t num, double noise_px_s, double share_of_fish) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<EpipolarSample> result(num);
    for (std::size_t i = 0; i < num; ++i) {
        EpipolarSample& s = result[i];
        s.ray = {0.7 * uniform(random), 0.5 * uniform(random)};
        s.inverse_depth_1_m = 0.5 + 0.3 * uniform(random);
        s.rate_px_s = rate_px_s(s) + noise_px_s * normal(random);
        if (static_cast<double>(i) < share_of_fish * static_cast<double>(num)) s.rate_px_s += 40.0;
    }
    return result;
}

double rms_error_px_s(const std::vector<EpipolarSample>& samples) {
    double squares = 0.0;
    for (const EpipolarSample& s : samples) squares += std::pow(s.rate_px_s - rate_px_s(s), 2);
    return std::sqrt(squares / static_cast<double>(samples.size()));
}

TEST(SmoothRatesTest, KeepsTheRatesOfACamerasMotion) {
    std::vector<EpipolarSample> exact = samples(150, 0.0, 0.0);
    smooth_rates(exact);
    EXPECT_LT(rms_error_px_s(exact), 0.01);
}

TEST(SmoothRatesTest, RemovesMostOfTheNoiseBesidesFish) {
    std::vector<EpipolarSample> noisy = samples(200, 1.5, 0.15);
    ASSERT_GT(rms_error_px_s(noisy), 10.0);
    smooth_rates(noisy);
    EXPECT_LT(rms_error_px_s(noisy), 0.5);
}

TEST(SmoothRatesTest, LeavesAFewSamplesAsTheyAre) {
    std::vector<EpipolarSample> few = samples(20, 1.5, 0.0);
    const double before = rms_error_px_s(few);
    smooth_rates(few);
    EXPECT_EQ(rms_error_px_s(few), before);
}

}  // namespace
}  // namespace divemesh::dive
