#include "schemas/truth_options.hpp"

#include <gtest/gtest.h>

namespace divemesh {
namespace {

TEST(TruthOptions, ALeverArmIsThreeNumbersOrAPoseOrSolved) {
    TruthOptions options;
    set_lever_arm(options, "0.1, -0.2,3e-1");
    ASSERT_TRUE(options.lever_arm);
    EXPECT_EQ(options.lever_arm->position_m, (std::array<double, 3>{0.1, -0.2, 0.3}));
    set_lever_arm(options, "0,0,0,0,0,0,1");
    EXPECT_EQ(options.lever_arm->orientation_wxyz, (std::array<double, 4>{0, 0, 0, 1}));
    set_lever_arm(options, "solve");
    EXPECT_TRUE(options.solve_lever_arm);
    EXPECT_FALSE(options.lever_arm);
}

TEST(TruthOptions, AnOffsetIsSecondsOrSolved) {
    TruthOptions options;
    set_time_offset(options, "-0.25");
    EXPECT_EQ(options.time_offset_s, -0.25);
    set_time_offset(options, "solve");
    EXPECT_TRUE(options.solve_time_offset);
}

TEST(TruthOptions, WhatIsNeitherIsRefused) {
    TruthOptions options;
    for (const char* text : {"",
                             "1",
                             "1,2",
                             "1,2,3,",
                             "1,2,3,4",
                             "a,b,c",
                             "nan,0,0",
                             "1e9,0,0",
                             "0,0,0,2,0,0,0",
                             "1 2 3"})
        EXPECT_THROW(set_lever_arm(options, text), Error) << text;
    for (const char* text : {"", "soon", "1,2", "inf", "1e10", "5s"})
        EXPECT_THROW(set_time_offset(options, text), Error) << text;
}

}  // namespace
}  // namespace divemesh
