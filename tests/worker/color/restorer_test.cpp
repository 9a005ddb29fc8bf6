#include "worker/color/restorer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/worker/color/water_world.hpp"

namespace divemesh::color {
namespace {

ColorFit known_fit(LightSource light) {
    ColorFit fit;
    fit.outcome = FitOutcome::Estimated;
    fit.light = light;
    fit.channels = green_water(0.8);
    fit.vignetting = 0.25;
    fit.near_m = 0.5;
    fit.far_m = 5.0;
    fit.log_gains = {0.0, 0.2};
    return fit;
}

std::array<float, 3> seen(const ColorFit& fit,
                          const std::array<double, 3>& color,
                          double range_m,
                          std::size_t keyframe,
                          double eccentricity,
                          double cosine) {
    std::array<float, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<float>(
            std::exp(fit.log_gains[keyframe]) * (1.0 - fit.vignetting * eccentricity) *
            (color[c] * direct_of(fit.channels[c], fit.light, range_m, cosine) +
             backscatter(fit.channels[c], range_m)));
    return rgb;
}

class RestorerTest : public testing::TestWithParam<LightSource> {};

TEST_P(RestorerTest, ReturnsTheColourThatTheModelMadeTheImageFrom) {
    const ColorFit fit = known_fit(GetParam());
    const WhitePoint white{.white = {0.5, 0.8, 1.0}};
    const Restorer restorer(fit, white);
    const std::array<double, 3> color = {0.4, 0.3, 0.2};
    for (const double range_m : {0.6, 1.3, 1.8}) {
        const auto restored = restorer.restore(
            {seen(fit, color, range_m, 1, 0.6, 0.7), static_cast<float>(range_m), 0.6F, 0.7F}, 1);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(restored.rgb[c], color[c] / white.white[c], 0.002) << range_m;
        EXPECT_FALSE(restored.is_limited);
    }
}

INSTANTIATE_TEST_SUITE_P(AllLights,
                         RestorerTest,
                         testing::Values(LightSource::Ambient,
                                         LightSource::Camera,
                                         LightSource::Mixed));

TEST(Restorer, AmplifiesNoMoreThanTheNoiseAllows) {
    ColorFit fit = known_fit(LightSource::Ambient);
    fit.channels[0].attenuation_per_m.value = 2.0;  // e^10 at 5 m
    fit.channels[0].noise = 0.002;
    const Restorer restorer(fit, {});
    const auto restored = restorer.restore({{0.01F, 0.2F, 0.2F}, 5.0F}, 0);
    EXPECT_TRUE(restored.is_limited);
    EXPECT_LE(restored.rgb[0], 0.01F * 0.1F / 0.002F);
    EXPECT_FALSE(restorer.restore({{0.01F, 0.2F, 0.2F}, 1.0F}, 0).is_limited);
}

// The noise of an image is amplified by the inverse of its gain and of its vignetting as well.
TEST(Restorer, LimitsTheWholeFactor) {
    ColorFit fit = known_fit(LightSource::Ambient);
    fit.channels[0].noise = 0.01;  // a factor of 10; that of the water is 5.2 at 3 m
    fit.log_gains = {0.0, -1.0};
    const Restorer restorer(fit, {});
    const Restorer::Seen middle{{0.1F, 0.2F, 0.2F}, 3.0F};
    Restorer::Seen corner = middle;
    corner.eccentricity = 1.0F;
    EXPECT_FALSE(restorer.restore(middle, 0).is_limited);
    const RestoredColor dim = restorer.restore(middle, 1);
    EXPECT_TRUE(dim.is_limited);
    EXPECT_LE(dim.rgb[0], 0.1F * 10.0F);
    EXPECT_GT(dim.amplification, restorer.restore(middle, 0).amplification);
    EXPECT_NEAR(restorer.restore(corner, 0).amplification,
                restorer.restore(middle, 0).amplification / (1.0 - fit.vignetting),
                0.01);
}

TEST(Restorer, SaysWhereItDoesNotReach) {
    const Restorer restorer(known_fit(LightSource::Ambient), {});
    EXPECT_FALSE(restorer.restore({{0.1F, 0.2F, 0.2F}, 4.0F}, 0).is_limited);
    EXPECT_TRUE(restorer.restore({{0.1F, 0.2F, 0.2F}, 5.1F}, 0).is_limited);
}

TEST(Restorer, TakesRangesBeyondTheFitForTheNearestOfThem) {
    const ColorFit fit = known_fit(LightSource::Mixed);
    const Restorer restorer(fit, {});
    const std::array<float, 3> rgb = {0.1F, 0.2F, 0.2F};
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_FLOAT_EQ(restorer.restore({rgb, 50.0F}, 0).rgb[c],
                        restorer.restore({rgb, 5.0F}, 0).rgb[c]);
        EXPECT_FLOAT_EQ(restorer.restore({rgb, 0.0F}, 0).rgb[c],
                        restorer.restore({rgb, 0.5F}, 0).rgb[c]);
    }
}

TEST(Restorer, IsMadeOfKnownWaterAlone) { EXPECT_THROW(Restorer({}, {}), std::logic_error); }

}  // namespace
}  // namespace divemesh::color
