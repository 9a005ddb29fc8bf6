#include "tests/bench/ciede2000.hpp"

#include <gtest/gtest.h>

namespace divemesh::bench {
namespace {

// Pairs of the table of Sharma, Wu and Dalal (2005).
TEST(Ciede2000, HasThePublishedValues) {
    EXPECT_NEAR(ciede2000({50.0, 2.6772, -79.7751}, {50.0, 0.0, -82.7485}), 2.0425, 1e-4);
    EXPECT_NEAR(ciede2000({50.0, -1.3802, -84.2814}, {50.0, 0.0, -82.7485}), 1.0, 1e-4);
    EXPECT_NEAR(ciede2000({50.0, 2.5, 0.0}, {73.0, 25.0, -18.0}), 27.1492, 1e-4);
    EXPECT_NEAR(ciede2000({50.0, 2.5, 0.0}, {50.0, 0.0, -2.5}), 4.3065, 1e-4);
    EXPECT_NEAR(ciede2000({50.0, 2.4900, -0.0010}, {50.0, -2.4900, 0.0009}), 7.1792, 1e-4);
    EXPECT_NEAR(
        ciede2000({60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}), 1.2644, 1e-4);
    EXPECT_NEAR(
        ciede2000({22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}), 2.0373, 1e-4);
}

TEST(Ciede2000, TakesSrgbsWhiteForWhite) {
    const Lab white = lab_of({1.0, 1.0, 1.0});
    EXPECT_NEAR(white.l, 100.0, 1e-3);
    EXPECT_NEAR(white.a, 0.0, 0.02);
    EXPECT_NEAR(white.b, 0.0, 0.02);
    EXPECT_NEAR(lab_of({0.18418651851, 0.18418651851, 0.18418651851}).l, 50.0, 1e-3);
}

}  // namespace
}  // namespace divemesh::bench
