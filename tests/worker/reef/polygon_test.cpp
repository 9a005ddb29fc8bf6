#include "worker/reef/polygon.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::reef {
namespace {

const Polygon kLetterL = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};

TEST(Polygon, AreaIsThatOfTheShoelaceWhicheverWayItRuns) {
    Polygon backwards(kLetterL.rbegin(), kLetterL.rend());
    EXPECT_DOUBLE_EQ(area_m2(kLetterL), 3.0);
    EXPECT_DOUBLE_EQ(area_m2(backwards), 3.0);
}

TEST(Polygon, ContainsWhatIsInsideAndItsBorder) {
    EXPECT_TRUE(contains(kLetterL, {0.5, 1.5}));
    EXPECT_TRUE(contains(kLetterL, {1.0, 1.5}));
    EXPECT_TRUE(contains(kLetterL, {2.0, 1.0}));
    EXPECT_FALSE(contains(kLetterL, {1.5, 1.5}));
}

TEST(Polygon, SidesThatCrossOrTouchAreFound) {
    EXPECT_FALSE(is_self_crossing(kLetterL));
    EXPECT_TRUE(is_self_crossing({{0, 0}, {1, 1}, {1, 0}, {0, 1}}));          // bow tie
    EXPECT_TRUE(is_self_crossing({{0, 0}, {2, 0}, {2, 2}, {1, 0}, {0, 2}}));  // touches itself
    EXPECT_TRUE(is_self_crossing({{0, 0}, {1, 0}, {1, 0}, {0, 1}}));          // a point twice
}

TEST(Polygon, OverlapWithATriangleIsExactEvenWhereThePolygonIsConcave) {
    EXPECT_DOUBLE_EQ(overlap_m2(kLetterL, {0, 0}, {2, 0}, {0, 2}), 2.0);
    EXPECT_NEAR(overlap_m2(kLetterL, {2, 2}, {0, 2}, {2, 0}), 1.0, 1e-12);
    EXPECT_DOUBLE_EQ(overlap_m2(kLetterL, {3, 3}, {4, 3}, {3, 4}), 0.0);
}

TEST(Polygon, LongestDiameterIsBetweenTheFarthestCorners) {
    EXPECT_NEAR(max_diameter_m(kLetterL), std::sqrt(8.0), 1e-12);
}

}  // namespace
}  // namespace divemesh::reef
