#include "worker/color/fit_water.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "schemas/error.hpp"
#include "tests/worker/color/water_world.hpp"

namespace divemesh::color {
namespace {

void expect_within(const Value& estimated, double truth, double share) {
    EXPECT_NEAR(estimated.value, truth, share * truth);
    EXPECT_GT(estimated.sigma, 0.0);
    EXPECT_LT(std::abs(estimated.value - truth), 4.0 * estimated.sigma);
}

void expect_channels_of(const ColorFit& fit, const WaterWorld& world) {
    ASSERT_EQ(fit.outcome, FitOutcome::Estimated) << to_string(fit.outcome);
    EXPECT_EQ(fit.light, world.light) << to_string(fit.light);
    EXPECT_NEAR(fit.vignetting, world.vignetting, 0.02);
    EXPECT_GT(fit.explained_share, 0.5);
    for (std::size_t c = 0; c < 3; ++c) {
        SCOPED_TRACE("channel " + std::to_string(c));
        const ChannelFit& truth = world.channels[c];
        EXPECT_TRUE(fit.channels[c].known);
        expect_within(fit.channels[c].attenuation_per_m, truth.attenuation_per_m.value, 0.15);
        expect_within(fit.channels[c].backscatter_per_m, truth.backscatter_per_m.value, 0.3);
        // Where backscatter does not saturate, its coefficient and the veil are known less well
        // than their product, which is what it begins with.
        EXPECT_NEAR(fit.channels[c].veil.value * fit.channels[c].backscatter_per_m.value,
                    truth.veil.value * truth.backscatter_per_m.value,
                    0.15 * truth.veil.value * truth.backscatter_per_m.value);
    }
}

TEST(FitWater, FindsAttenuationAndBackscatterUnderTheSky) {
    const WaterWorld world{.channels = green_water()};
    expect_channels_of(fit_water(draw_sightings(world, 1), 2), world);
}

TEST(FitWater, FindsThemByLampsThatTravelWithTheCamera) {
    const WaterWorld world{.channels = green_water(), .light = LightSource::Camera};
    expect_channels_of(fit_water(draw_sightings(world, 2), 2), world);
}

TEST(FitWater, FindsThemByBothKindsOfLight) {
    const WaterWorld world{.channels = green_water(1.0), .light = LightSource::Mixed};
    const ColorFit fit = fit_water(draw_sightings(world, 3), 2);
    expect_channels_of(fit, world);
    for (std::size_t c = 0; c < 3; ++c)
        expect_within(fit.channels[c].lamp, world.channels[c].lamp.value, 0.3);
}

// Over many dives the errors are as large as stated: their mean square in sigmas is about 1.
TEST(FitWater, StatesHowUncertainItIs) {
    WaterWorld world{.channels = green_water(), .num_points = 200, .num_keyframes = 12};
    world.num_sightings = 8;
    double sum = 0.0;
    int num = 0;
    for (std::uint32_t seed = 10; seed < 40; ++seed) {
        const ColorFit fit = fit_water(draw_sightings(world, seed), 2);
        for (std::size_t c = 0; c < 3; ++c) {
            const Value& attenuation = fit.channels[c].attenuation_per_m;
            const double error =
                (attenuation.value - world.channels[c].attenuation_per_m.value) / attenuation.sigma;
            sum += error * error;
            ++num;
        }
    }
    EXPECT_GT(sum / num, 0.7);
    EXPECT_LT(sum / num, 1.35);
}

TEST(FitWater, FollowsTheExposure) {
    const WaterWorld world{.channels = green_water(), .gain_sigma = 0.4};
    expect_channels_of(fit_water(draw_sightings(world, 4), 2), world);
}

TEST(FitWater, GivesTheSameBytesForAnyNumberOfThreads) {
    const WaterWorld world{.channels = green_water(), .num_points = 300};
    const Sightings sightings = draw_sightings(world, 5);
    const ColorFit one = fit_water(sightings, 1);
    const ColorFit eight = fit_water(sightings, 8);
    EXPECT_EQ(one.channels, eight.channels);
    EXPECT_EQ(one.log_gains, eight.log_gains);
    EXPECT_EQ(one.surface, eight.surface);
}

TEST(FitWater, FindsNothingToRestoreInAir) {
    const WaterWorld world{
        .channels = {channel_of(0, 0, 0), channel_of(0, 0, 0), channel_of(0, 0, 0)}};
    EXPECT_EQ(fit_water(draw_sightings(world, 6), 2).outcome, FitOutcome::NothingToRestore);
}

TEST(FitWater, NeedsSurfaceSeenFromDifferentRanges) {
    const WaterWorld world{.channels = green_water(), .near_m = 2.0, .far_m = 2.1};
    EXPECT_EQ(fit_water(draw_sightings(world, 7), 2).outcome, FitOutcome::TooLittleRange);
}

TEST(FitWater, NeedsSurfaceSeenByThreeKeyframes) {
    WaterWorld world{.channels = green_water()};
    world.num_sightings = 2;
    const ColorFit fit = fit_water(draw_sightings(world, 8), 2);
    EXPECT_EQ(fit.outcome, FitOutcome::TooFewSightings);
    EXPECT_EQ(fit.num_points, 0);
    EXPECT_EQ(fit_water({}, 1).outcome, FitOutcome::TooFewSightings);
}

TEST(FitWater, ReportsItsStepsAndCanBeCancelled) {
    const Sightings sightings = draw_sightings({.channels = green_water(), .num_points = 200}, 8);
    std::vector<double> reported;
    const auto note = [&](const Progress& progress) { reported.push_back(progress.fraction); };
    fit_water(sightings, 2, {"color", 0.4, 0.6, note});
    ASSERT_GT(reported.size(), 10U);
    EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
    EXPECT_EQ(reported.front(), 0.4);
    EXPECT_LT(reported.back(), 0.6);
    const auto cancel = [](const Progress&) { throw Error(ErrorCode::Cancelled, "cancelled"); };
    EXPECT_THROW(fit_water(sightings, 2, {"color", 0.4, 0.6, cancel}), Error);
}

// Colours that scatter far more than the water changes them are no ground to change them.
TEST(FitWater, LeavesColoursThatWaterDoesNotExplain) {
    const WaterWorld world{.channels = {channel_of(0.06, 0.05, 0.02),
                                        channel_of(0.05, 0.04, 0.02),
                                        channel_of(0.05, 0.04, 0.02)},
                           .noise = 0.5};
    const ColorFit fit = fit_water(draw_sightings(world, 9), 2);
    EXPECT_EQ(fit.outcome, FitOutcome::NotExplained) << to_string(fit.outcome);
}

}  // namespace
}  // namespace divemesh::color
