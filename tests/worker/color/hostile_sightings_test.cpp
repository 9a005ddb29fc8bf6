#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/worker/color/water_world.hpp"
#include "worker/color/fit_water.hpp"

// Dives that do not tell their water, or tell it badly.
namespace divemesh::color {
namespace {

const WaterWorld kSmallDive{.channels = green_water(), .num_points = 400};

// Returns the sightings of a dive with the light changed by change(rgb).
template <typename Change>
Sightings changed(const WaterWorld& world, std::uint32_t seed, const Change& change) {
    Sightings sightings = draw_sightings(world, seed);
    for (Sighting& sighting : sightings.all) change(sighting.rgb);
    return sightings;
}

TEST(HostileSightings, OfOneKeyframeAreTooFew) {
    WaterWorld world = kSmallDive;
    world.num_keyframes = 1;
    world.num_sightings = 1;
    EXPECT_EQ(fit_water(draw_sightings(world, 1), 2).outcome, FitOutcome::TooFewSightings);
}

TEST(HostileSightings, WithoutLightAreTooDark) {
    const ColorFit fit = fit_water(changed(kSmallDive, 2, [](Rgb& rgb) { rgb = {}; }), 2);
    EXPECT_EQ(fit.outcome, FitOutcome::ChannelTooDark) << to_string(fit.outcome);
    for (const ChannelFit& channel : fit.channels) EXPECT_FALSE(channel.known);
}

void expect_only_red_unknown(const ColorFit& fit) {
    EXPECT_EQ(fit.outcome, FitOutcome::ChannelTooDark) << to_string(fit.outcome);
    EXPECT_FALSE(fit.channels[0].known);
    EXPECT_GT(fit.channels[0].attenuation_per_m.sigma, 0.5);
    for (std::size_t c = 1; c < 3; ++c) {
        const double truth = kSmallDive.channels[c].attenuation_per_m.value;
        EXPECT_TRUE(fit.channels[c].known);
        EXPECT_NEAR(fit.channels[c].attenuation_per_m.value, truth, 0.15 * truth);
    }
    EXPECT_GT(fit.explained_share, 0.5);
}

TEST(HostileSightings, WithoutRedTellTheOtherChannels) {
    expect_only_red_unknown(fit_water(changed(kSmallDive, 3, [](Rgb& rgb) { rgb[0] = 0.0F; }), 2));
}

// Under 25 m of water red is less than the lowest level of the image but for a few bright places.
TEST(HostileSightings, WithRedClippedAtDepthTellTheOtherChannels) {
    const auto at_depth = [](Rgb& rgb) { rgb[0] = rgb[0] > 0.35F ? 0.01F * rgb[0] : 0.0F; };
    expect_only_red_unknown(fit_water(changed(kSmallDive, 4, at_depth), 2));
}

TEST(HostileSightings, ThatAreSaturatedAreNotUsed) {
    const ColorFit fit = fit_water(changed(kSmallDive, 5, [](Rgb& rgb) { rgb.fill(1.0F); }), 2);
    EXPECT_EQ(fit.outcome, FitOutcome::TooFewSightings);
    EXPECT_EQ(fit.num_sightings, 0);
}

TEST(HostileSightings, ThatAreNotFiniteAreNotUsed) {
    Sightings sightings = draw_sightings(kSmallDive, 6);
    for (std::size_t i = 0; i < sightings.all.size(); i += 7)
        sightings.all[i].rgb[i % 3] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(fit_water(sightings, 2).outcome, FitOutcome::Estimated);
}

TEST(HostileSightings, OfSurfaceAtNoRangeOrFromBehindAreNotUsed) {
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    const Sightings clean = draw_sightings(kSmallDive, 6);
    const auto spoil = [](Sighting& sighting, std::size_t kind) {
        if (kind == 0) sighting.range_m = kNaN;
        if (kind == 1) sighting.range_m = std::numeric_limits<float>::infinity();
        if (kind == 2) sighting.range_m = 0.0F;
        if (kind == 3) sighting.eccentricity = kNaN;
        if (kind == 4) sighting.cosine = 0.0F;
        if (kind == 5) sighting.cosine = -0.5F;
        if (kind == 6) sighting.cosine = kNaN;
    };
    Sightings sightings = clean;
    std::int64_t num_spoilt = 0;
    for (std::size_t i = 0; i < sightings.all.size(); i += 9, ++num_spoilt)
        spoil(sightings.all[i], static_cast<std::size_t>(num_spoilt % 7));
    const ColorFit fit = fit_water(sightings, 2);
    EXPECT_EQ(fit.outcome, FitOutcome::Estimated) << to_string(fit.outcome);
    EXPECT_EQ(fit.num_sightings, static_cast<std::int64_t>(clean.all.size()) - num_spoilt);
}

TEST(HostileSightings, OfAGreyDiveHaveNoColour) {
    const auto grey = [](Rgb& rgb) { rgb.fill(rgb[1]); };
    EXPECT_EQ(fit_water(changed(kSmallDive, 7, grey), 2).outcome, FitOutcome::Grey);
}

TEST(HostileSightings, OfLampsInAirHaveNothingToRestore) {
    WaterWorld world = kSmallDive;
    world.channels = {channel_of(0, 0, 0), channel_of(0, 0, 0), channel_of(0, 0, 0)};
    world.light = LightSource::Camera;
    const ColorFit fit = fit_water(draw_sightings(world, 8), 2);
    EXPECT_EQ(fit.outcome, FitOutcome::NothingToRestore) << to_string(fit.outcome);
    EXPECT_LT(fit.explained_share, 0.1);  // it is the lamps that explain the light, not water
}

TEST(HostileSightings, ThatBrightenWithTheRangeAreNotExplained) {
    WaterWorld world = kSmallDive;
    for (ChannelFit& channel : world.channels) channel = channel_of(-0.15, 0.2, 0.0);
    const ColorFit fit = fit_water(draw_sightings(world, 9), 2);
    EXPECT_EQ(fit.outcome, FitOutcome::NotExplained) << to_string(fit.outcome);
}

// The veil ends at its bound; what is known of the attenuation is not lost with it.
TEST(HostileSightings, WithoutBackscatterTellTheAttenuation) {
    WaterWorld world = kSmallDive;
    for (ChannelFit& channel : world.channels) channel.veil = {};
    const ColorFit fit = fit_water(draw_sightings(world, 10), 2);
    ASSERT_EQ(fit.outcome, FitOutcome::Estimated) << to_string(fit.outcome);
    for (std::size_t c = 0; c < 3; ++c) {
        const Value& attenuation = fit.channels[c].attenuation_per_m;
        EXPECT_NEAR(attenuation.value,
                    world.channels[c].attenuation_per_m.value,
                    std::min(4.0 * attenuation.sigma, 0.05));
        EXPECT_LT(fit.channels[c].veil.value, 0.01);
        EXPECT_GT(fit.channels[c].veil.sigma, 0.0);
    }
}

// More keyframes than gains: those between are interpolated.
TEST(HostileSightings, OfManyKeyframesTellTheExposure) {
    const WaterWorld world{
        .channels = green_water(), .gain_sigma = 0.0, .gain_wave = 0.3, .num_keyframes = 1001};
    const ColorFit fit = fit_water(draw_sightings(world, 11), 2);
    ASSERT_EQ(fit.outcome, FitOutcome::Estimated) << to_string(fit.outcome);
    ASSERT_EQ(fit.log_gains.size(), 1001U);
    double offset = 0.0;
    for (std::size_t k = 0; k < 1001; ++k)
        offset += (fit.log_gains[k] - log_wave(world, k)) / 1001.0;
    double squared = 0.0;
    for (std::size_t k = 0; k < 1001; ++k)
        squared += std::pow(fit.log_gains[k] - log_wave(world, k) - offset, 2.0) / 1001.0;
    EXPECT_LT(std::sqrt(squared), 0.03);
}

}  // namespace
}  // namespace divemesh::color
