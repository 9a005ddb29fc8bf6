#include "worker/reef/population_change.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::reef {
namespace {

std::vector<Individual> individuals(std::size_t num, const Individual& each) {
    return std::vector<Individual>(num, each);
}

TEST(PopulationChange, WithNoneGoneTheCountHasThePoissonIntervalOfWhatIsNew) {
    auto colonies = individuals(10, {std::nullopt, 0.01});
    for (const Individual& old : individuals(50, {0.02, 0.03})) colonies.push_back(old);
    const stats::Estimate change = count_change(colonies);
    EXPECT_DOUBLE_EQ(change.value, 10.0);
    EXPECT_NEAR(change.high, 18.391, 0.02);  // Garwood's limit for a count of 10
    // None has gone, for which Garwood's upper limit is 3.689; combined with 10 - 4.795 (MOVER).
    EXPECT_NEAR(change.low, 10.0 - std::hypot(10.0 - 4.795, 3.689), 0.05);
}

TEST(PopulationChange, WhatStayedAsItWasLeavesTheCoverAsItWas) {
    const stats::Estimate change = sum_change(individuals(40, {0.02, 0.02}));
    EXPECT_DOUBLE_EQ(change.value, 0.0);
    EXPECT_DOUBLE_EQ(change.low, 0.0);
    EXPECT_DOUBLE_EQ(change.high, 0.0);
}

TEST(PopulationChange, SumsVaryByTheSquaresOfTheDifferences) {
    auto colonies = individuals(9, {0.02, 0.03});
    colonies.push_back({0.05, std::nullopt});
    const stats::Estimate change = sum_change(colonies);
    EXPECT_NEAR(change.value, 0.04, 1e-12);
    EXPECT_NEAR(change.high - change.value, 1.96 * std::sqrt(9 * 1e-4 + 25e-4), 1e-4);
}

TEST(PopulationChange, AMedianThatDoubledIsSaidToHaveDoubled) {
    std::vector<Individual> colonies;
    for (int i = 1; i <= 21; ++i) colonies.push_back({0.01 * i, 0.02 * i});
    const auto change = median_change(colonies, 1);
    ASSERT_TRUE(change);
    EXPECT_NEAR(change->value, 0.11, 1e-12);
    EXPECT_LT(change->low, 0.11);
    EXPECT_GT(change->low, 0.0);
    EXPECT_GT(change->high, 0.11);
}

TEST(PopulationChange, AMedianOfNoneIsNotSaid) {
    EXPECT_FALSE(median_change({}, 1));
    EXPECT_FALSE(median_change(individuals(5, {0.01, std::nullopt}), 1));
}

}  // namespace
}  // namespace divemesh::reef
