#include "worker/stats/quantile.hpp"

#include <gtest/gtest.h>

namespace divemesh::stats {
namespace {

// numpy.quantile([1, 2, 4, 8], q) with method "linear" (the default) and "lower".
TEST(QuantileTest, InterpolatesAsNumPyDoesByDefault) {
    EXPECT_DOUBLE_EQ(quantile_of_sorted({1, 2, 4, 8}, 0.0), 1.0);
    EXPECT_DOUBLE_EQ(quantile_of_sorted({1, 2, 4, 8}, 0.25), 1.75);
    EXPECT_DOUBLE_EQ(quantile_of_sorted({1, 2, 4, 8}, 0.5), 3.0);
    EXPECT_DOUBLE_EQ(quantile_of_sorted({1, 2, 4, 8}, 0.9), 6.8);
    EXPECT_DOUBLE_EQ(quantile_of_sorted({1, 2, 4, 8}, 1.0), 8.0);
}

TEST(QuantileTest, TheLowerOneIsTheValueBelow) {
    EXPECT_EQ(lower_quantile<double>({8, 1, 4, 2}, 0.25), 1.0);
    EXPECT_EQ(lower_quantile<double>({8, 1, 4, 2}, 0.5), 2.0);
    EXPECT_EQ(lower_quantile<double>({8, 1, 4, 2}, 0.9), 4.0);
    EXPECT_EQ(lower_quantile<double>({8, 1, 4, 2}, 1.0), 8.0);
}

TEST(QuantileTest, TheUpperOneHasThatShareOfTheValuesBeforeIt) {
    EXPECT_EQ(upper_quantile<double>({8, 1, 4, 2}, 0.0), 1.0);
    EXPECT_EQ(upper_quantile<double>({8, 1, 4, 2}, 0.25), 2.0);
    EXPECT_EQ(upper_quantile<double>({8, 1, 4, 2}, 0.5), 4.0);
    EXPECT_EQ(upper_quantile<double>({8, 1, 4, 2}, 0.7), 4.0);
    EXPECT_EQ(upper_quantile<double>({8, 1, 4, 2}, 1.0), 8.0);
}

TEST(QuantileTest, OfOneValueItIsThatValueAndOfNoneZero) {
    EXPECT_EQ(quantile_of_sorted({3.0}, 0.9), 3.0);
    EXPECT_EQ(lower_quantile<float>({3.0F}, 0.9), 3.0F);
    EXPECT_EQ(upper_quantile<float>({3.0F}, 0.9), 3.0F);
    EXPECT_EQ(quantile_of_sorted({}, 0.5), 0.0);
    EXPECT_EQ(lower_quantile<float>({}, 0.5), 0.0F);
    EXPECT_EQ(upper_quantile<float>({}, 0.5), 0.0F);
}

}  // namespace
}  // namespace divemesh::stats
