#include "worker/stats/robust.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace divemesh::stats {
namespace {

// Beaton and Tukey (1974): the derivative of the loss is the weighted residual.
TEST(RobustTest, TheDerivativeOfTheLossIsTheWeightedResidual) {
    constexpr double kStep = 1e-6;
    for (const double residual : {-6.0, -4.0, -0.5, 0.0, 1.0, 2.5, 4.6, 9.0}) {
        const double slope =
            (tukey_loss(residual + kStep, kTukey) - tukey_loss(residual - kStep, kTukey)) /
            (2.0 * kStep);
        EXPECT_NEAR(slope, tukey_weight(residual, kTukey) * residual, 1e-6) << residual;
    }
}

TEST(RobustTest, TheLossOfAnOutlierIsASixthOfTheSquaredLimit) {
    EXPECT_DOUBLE_EQ(tukey_loss(1e6, 3.0), 1.5);
}

TEST(RobustTest, TheLossOfNoNumberIsNone) {
    EXPECT_TRUE(std::isnan(tukey_loss(std::numeric_limits<double>::quiet_NaN(), kTukey)));
}

}  // namespace
}  // namespace divemesh::stats
