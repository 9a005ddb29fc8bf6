#include <gtest/gtest.h>

#include <cmath>

#include "worker/fusion/packed_lanes.hpp"

namespace divemesh::fusion {
namespace {

TEST(PackedWeight, KeepsElevenBitsOverFifteenDecades) {
    for (double weight = 1e-5; weight < 1e12; weight *= 1.37) {
        const auto value = static_cast<float>(weight);
        EXPECT_NEAR(unpack_weight(pack_weight(value)) / value, 1.0F, std::ldexp(1.0F, -11));
    }
    EXPECT_EQ(unpack_weight(0), 0.0F);
}

TEST(PackedWeight, WhatIsTooSmallOrTooLargeStaysAWeight) {
    EXPECT_GT(unpack_weight(pack_weight(1e-30F)), 0.0F);
    EXPECT_GT(unpack_weight(pack_weight(1e30F)), 1e12F);
}

TEST(PackedWeight, EightAtOnceAreTheSameAsOne) {
    const base::Floats weights = {1e-9F, 0.03F, 1.0F, 77.7F, 12345.6F, 9.9e8F, 3e13F, 1e20F};
    const base::Masks packed_weights = pack_weights(weights);
    const base::Floats unpacked = unpack_weights(packed_weights);
    for (int i = 0; i < base::kLanes; ++i) {
        EXPECT_EQ(packed_weights[i], pack_weight(weights[i])) << i;
        EXPECT_EQ(unpacked[i], unpack_weight(static_cast<std::uint16_t>(packed_weights[i]))) << i;
    }
    EXPECT_EQ(unpack_weights(base::Masks{})[3], 0.0F);
}

TEST(PackedTriple, HoldsEveryGreyValueOfEveryChannel) {
    for (int channel = 0; channel < 3; ++channel)
        for (int grey = 0; grey < 256; ++grey) {
            const std::int32_t steps = grey * PackedTriple::steps_per_grey(channel) + 1;
            const std::uint32_t color = packed(steps, channel);
            EXPECT_NE(color, 0U);
            EXPECT_EQ(unpack_grey(color, channel), grey);
        }
}

}  // namespace
}  // namespace divemesh::fusion
