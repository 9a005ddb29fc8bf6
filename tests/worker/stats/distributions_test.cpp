#include "worker/stats/distributions.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::stats {
namespace {

// Values as in the NIST/SEMATECH handbook, sections 1.3.6.7.2 and 1.3.6.7.4.
TEST(DistributionsTest, StudentsQuantilesAreThoseOfTheTables) {
    EXPECT_NEAR(student_t_quantile(0.975, 1), 12.706, 5e-4);
    EXPECT_NEAR(student_t_quantile(0.975, 5), 2.571, 5e-4);
    EXPECT_NEAR(student_t_quantile(0.975, 10), 2.228, 5e-4);
    EXPECT_NEAR(student_t_quantile(0.95, 30), 1.697, 5e-4);
    EXPECT_NEAR(student_t_quantile(0.975, 99), 1.984, 5e-4);
}

TEST(DistributionsTest, ChiSquareQuantilesAreThoseOfTheTables) {
    EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841, 5e-4);
    EXPECT_NEAR(chi_square_quantile(0.95, 3), 7.815, 5e-4);
    EXPECT_NEAR(chi_square_quantile(0.975, 22), 36.781, 5e-4);
    EXPECT_NEAR(chi_square_quantile(0.025, 20), 9.591, 5e-4);
}

// With two degrees of freedom the distribution is exponential.
TEST(DistributionsTest, ChiSquareOfTwoDegreesOfFreedomIsExponential) {
    EXPECT_NEAR(chi_square_quantile(0.025, 2), -2.0 * std::log(0.975), 1e-12);
    EXPECT_NEAR(chi_square_quantile(0.95, 2), -2.0 * std::log(0.05), 1e-12);
}

TEST(DistributionsTest, AFractionOfADegreeOfFreedomLiesBetweenItsNeighbours) {
    EXPECT_GT(chi_square_quantile(0.95, 2.5), chi_square_quantile(0.95, 2));
    EXPECT_LT(chi_square_quantile(0.95, 2.5), chi_square_quantile(0.95, 3));
}

TEST(DistributionsTest, ManyDegreesOfFreedomLeadToTheNormalDistribution) {
    EXPECT_NEAR(student_t_quantile(0.975, 1e9), kNormal975, 1e-8);
    EXPECT_NEAR(student_t_quantile(0.95, 1e9), 1.6448536269514722, 1e-8);
}

TEST(DistributionsTest, NoDegreesOfFreedomGiveNoNumber) {
    EXPECT_TRUE(std::isnan(student_t_quantile(0.975, 0)));
    EXPECT_TRUE(std::isnan(chi_square_quantile(0.95, 0)));
    EXPECT_TRUE(std::isnan(chi_square_quantile(0.95, std::nan(""))));
}

}  // namespace
}  // namespace divemesh::stats
