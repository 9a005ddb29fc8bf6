#include "worker/dive/stereo_delay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace divemesh::dive {
namespace {

constexpr double kFocal_px = 700.0;
constexpr double kBaseline_m = 0.5;

// What the cameras of a rig see that drives ahead over even ground, whose right camera is rolled
// and exposes later. Near things move fastest, and lie in the right image where a roll moves them
// least.
std::vector<EpipolarMoment> driving(double roll_deg, double delay_s) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::normal_distribution<double> noise_px(0.0, 0.15);
    const double roll_rad = roll_deg * std::numbers::pi / 180.0;
    std::vector<EpipolarMoment> moments(8);
    for (std::size_t k = 0; k < moments.size(); ++k) {
        const double speed_m_s = 8.0 + 0.5 * static_cast<double>(k);
        moments[k].num_corners = 150;
        for (int i = 0; i < 150; ++i) {
            const double depth_m = 12.0 + 9.0 * uniform(random);
            const double height_m = i % 3 == 0 ? 2.0 * uniform(random) : 1.6;
            EpipolarSample sample;
            sample.ray = {0.8 * uniform(random), height_m / depth_m};
            sample.right_ray = sample.ray - Eigen::Vector2d(kBaseline_m / depth_m, 0.0);
            sample.inverse_depth_1_m = 1.0 / depth_m;
            sample.rate_px_s = -kFocal_px * sample.ray.y() * speed_m_s / depth_m;
            sample.error_px = kFocal_px * roll_rad * sample.right_ray.x() +
                              delay_s * sample.rate_px_s + noise_px(random);
            sample.speed_m_s = speed_m_s * sample.ray.norm();
            moments[k].samples.push_back(sample);
        }
    }
    return moments;
}

TEST(StereoDelayTest, ARolledCameraIsNotLate) {
    for (const double roll_deg : {-1.0, -0.4, 0.0, 0.4, 1.0}) {
        const StereoDelay delay = estimate_delay(driving(roll_deg, 0.0));
        EXPECT_TRUE(delay.is_determined) << roll_deg;
        EXPECT_FALSE(delay.is_significant()) << roll_deg << " deg: " << delay.delay_s << " s";
        EXPECT_LT(std::abs(delay.delay_s), 5e-4) << roll_deg;
    }
}

TEST(StereoDelayTest, FindsTheDelayOfARolledCamera) {
    for (const double roll_deg : {-1.0, 0.0, 1.0})
        for (const double delay_s : {-0.02, 0.008}) {
            const StereoDelay delay = estimate_delay(driving(roll_deg, delay_s));
            EXPECT_TRUE(delay.is_significant()) << roll_deg << " deg, " << delay_s << " s";
            EXPECT_NEAR(delay.delay_s, delay_s, 4.0 * delay.sigma_s);
            EXPECT_LT(delay.sigma_s, 1.5e-3);
        }
}

}  // namespace
}  // namespace divemesh::dive
