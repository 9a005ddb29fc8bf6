#include "worker/camera/gradient_magnitude.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace divemesh::camera {
namespace {

TEST(GradientMagnitudeTest, OfARampItIsItsSlope) {
    cv::Mat ramp(20, 30, CV_32F);
    for (int row = 0; row < ramp.rows; ++row)
        for (int column = 0; column < ramp.cols; ++column)
            ramp.at<float>(row, column) =
                3.0F * static_cast<float>(column) - 4.0F * static_cast<float>(row);

    const cv::Mat slope = gradient_magnitude(ramp);

    ASSERT_EQ(slope.type(), CV_32F);
    ASSERT_EQ(slope.size(), ramp.size());
    for (int row = 1; row + 1 < ramp.rows; ++row)
        for (int column = 1; column + 1 < ramp.cols; ++column)
            EXPECT_NEAR(slope.at<float>(row, column), 5.0F, 1e-4F);
}

TEST(GradientMagnitudeTest, OfAnEvenImageItIsZero) {
    EXPECT_EQ(cv::countNonZero(gradient_magnitude(cv::Mat(9, 9, CV_8UC1, cv::Scalar(77)))), 0);
}

}  // namespace
}  // namespace divemesh::camera
