#include "worker/reef/population.hpp"

#include <gtest/gtest.h>

namespace divemesh::reef {
namespace {

// Garwood's limits for counts of 10 and 1, as in tables of the Poisson distribution.
TEST(Population, DensityHasThePoissonIntervalOfTheTables) {
    const Population ten{std::vector<double>(10, 0.01), std::vector<double>(10, 0.1), 2.0};
    EXPECT_DOUBLE_EQ(density_per_m2(ten).value, 5.0);
    EXPECT_NEAR(density_per_m2(ten).low, 4.795 / 2.0, 5e-4);
    EXPECT_NEAR(density_per_m2(ten).high, 18.391 / 2.0, 5e-4);
    const Population one{{0.01}, {0.1}, 1.0};
    EXPECT_NEAR(density_per_m2(one).low, 0.0253, 5e-5);
    EXPECT_NEAR(density_per_m2(one).high, 5.572, 5e-4);
}

TEST(Population, CoverIsTheShareOfTheGroundAndAFewLargeColoniesMakeItLessCertain) {
    const Population many{std::vector<double>(100, 0.002), {}, 2.0};
    const Population few{std::vector<double>(2, 0.1), {}, 2.0};
    EXPECT_NEAR(cover(many).value, 0.1, 1e-12);
    EXPECT_NEAR(cover(many).high, 0.1 + 1.96 * 0.01, 1e-4);
    EXPECT_NEAR(cover(few).high, 0.1 + 1.96 * 0.0707, 1e-4);
}

TEST(Population, QuartilesAreThoseOfTheSizes) {
    const stats::Estimate median = size_quantile({5, 1, 4, 2, 3}, 0.5, 1);
    EXPECT_DOUBLE_EQ(median.value, 3.0);
    EXPECT_GE(median.low, 1.0);
    EXPECT_LE(median.high, 5.0);
    EXPECT_LT(median.low, median.high);
    EXPECT_DOUBLE_EQ(size_quantile({5, 1, 4, 2, 3}, 0.25, 1).value, 2.0);
}

}  // namespace
}  // namespace divemesh::reef
