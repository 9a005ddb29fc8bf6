#include "tests/bench/calibration_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::bench {
namespace {

TEST(CalibrationCurveTest, ABoundJustHoldsAtItsOwnLevel) {
    EXPECT_NEAR(level_of_normal(-1.959964, 1.0), 0.95, 1e-6);
    // Three degrees of freedom: root mean square sqrt(3), 95 % within sqrt(7.8147), half within
    // sqrt(2.366).
    EXPECT_NEAR(level_of_length(std::sqrt(7.8147), std::sqrt(3.0), std::sqrt(7.8147)), 0.95, 1e-6);
    EXPECT_NEAR(level_of_length(std::sqrt(2.366), std::sqrt(3.0), std::sqrt(7.8147)), 0.5, 1e-4);
}

TEST(CalibrationCurveTest, ADiveOfManyErrorsCountsOnce) {
    CalibrationCurve curve("x");
    curve.add(0.5);
    curve.add(std::vector<double>{0.97, 0.1, 0.2, 0.3});
    EXPECT_EQ(curve.num_dives(), 2U);
    EXPECT_NEAR(curve.held(0.95), 0.5 * (1.0 + 0.75), 1e-12);
    EXPECT_NEAR(curve.held(0.4), 0.5 * 0.75, 1e-12);
}

}  // namespace
}  // namespace divemesh::bench
