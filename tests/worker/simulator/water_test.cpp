#include "worker/simulator/water.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::simulator {
namespace {

TEST(WaterTest, ContrastFallsExponentiallyWithRange) {
    const Water water = make_water(WaterKind::Green);
    for (const float range_m : {0.5F, 1.0F, 2.0F, 4.0F}) {
        const Rgb contrast = water.look_through(Rgb(0.6F, 0.6F, 0.6F), range_m) -
                             water.look_through(Rgb(0.1F, 0.1F, 0.1F), range_m);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(contrast[c], 0.5F * std::exp(-water.attenuation_per_m[c] * range_m), 1e-6F);
    }
}

TEST(WaterTest, WhatIsFarAwayTakesTheColorOfTheWater) {
    const Water water = make_water(WaterKind::Turbid);
    EXPECT_TRUE(water.look_through(Rgb::Ones(), 60.0F).isApprox(water.veil, 1e-4F));
}

TEST(WaterTest, RedIsLostFirstAndTurbidWaterLosesMost) {
    const Water clear = make_water(WaterKind::Clear);
    const Water green = make_water(WaterKind::Green);
    const Water turbid = make_water(WaterKind::Turbid);
    for (const Water& water : {clear, green, turbid})
        EXPECT_GT(water.attenuation_per_m[0], water.attenuation_per_m[1]);
    EXPECT_TRUE((green.attenuation_per_m > clear.attenuation_per_m).all());
    EXPECT_TRUE((turbid.attenuation_per_m > green.attenuation_per_m).all());
}

TEST(WaterTest, AirChangesNothing) {
    const Water air = make_water(WaterKind::None);
    EXPECT_TRUE(air.look_through(Rgb(0.2F, 0.4F, 0.6F), 30.0F).isApprox(Rgb(0.2F, 0.4F, 0.6F)));
}

}  // namespace
}  // namespace divemesh::simulator
