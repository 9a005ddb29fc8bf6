#include "worker/stats/median.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace divemesh::stats {
namespace {

TEST(MedianTest, OfAnOddNumberItIsTheMiddleValue) {
    EXPECT_EQ(median({9.0, 1.0, 4.0}), 4.0);
    EXPECT_EQ(upper_median<double>({9.0, 1.0, 4.0}), 4.0);
}

TEST(MedianTest, OfAnEvenNumberItIsTheMeanOfTheTwoInTheMiddle) {
    EXPECT_EQ(median({9.0, 1.0, 2.0, 5.0}), 3.5);
}

TEST(MedianTest, TheUpperMedianOfAnEvenNumberIsTheLargerOfTheTwoInTheMiddle) {
    EXPECT_EQ(upper_median<double>({9.0, 1.0, 2.0, 5.0}), 5.0);
    EXPECT_EQ(upper_median<std::int64_t>({7, -3}), 7);
}

TEST(MedianTest, OfNoValuesItIsZero) {
    EXPECT_EQ(median({}), 0.0);
    EXPECT_EQ(upper_median<float>({}), 0.0F);
}

}  // namespace
}  // namespace divemesh::stats
