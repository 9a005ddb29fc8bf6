#include "worker/fusion/close_pinholes.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace divemesh::fusion {
namespace {

constexpr float kSigma_px = 0.2F;

// Returns the disparity of a tilted plane.
float plane(int x, int y) {
    return 20.0F + 0.3F * static_cast<float>(x) - 0.1F * static_cast<float>(y);
}

class ClosePinholes : public testing::Test {
protected:
    ClosePinholes() {
        for (int y = 0; y < disparity_px.rows; ++y)
            for (int x = 0; x < disparity_px.cols; ++x) disparity_px.at<float>(y, x) = plane(x, y);
    }
    void clear(const cv::Rect& hole) { disparity_px(hole).setTo(0.0F); }
    int num_unknown() const {
        return static_cast<int>(disparity_px.total()) - cv::countNonZero(disparity_px);
    }

    cv::Mat disparity_px = cv::Mat(40, 60, CV_32F);
    cv::Mat sigma_px = cv::Mat(40, 60, CV_32F, cv::Scalar(kSigma_px));
};

TEST_F(ClosePinholes, AHoleWithinAPlaneGetsThePlane) {
    clear({20, 15, 3, 3});
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(num_unknown(), 0);
    for (int y = 15; y < 18; ++y)
        for (int x = 20; x < 23; ++x) EXPECT_NEAR(disparity_px.at<float>(y, x), plane(x, y), 1e-4F);
}

TEST_F(ClosePinholes, AClosedPixelHasTheLargestSigmaAroundIt) {
    clear({20, 15, 1, 1});
    sigma_px.at<float>(15, 21) = 0.7F;
    close_pinholes(disparity_px, sigma_px);
    EXPECT_FLOAT_EQ(sigma_px.at<float>(15, 20), 0.7F);
    EXPECT_FLOAT_EQ(sigma_px.at<float>(15, 21), 0.7F);
    EXPECT_FLOAT_EQ(sigma_px.at<float>(15, 22), kSigma_px);
}

TEST_F(ClosePinholes, AWideHoleStaysOpenInItsMiddle) {
    clear({20, 10, 12, 12});
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(disparity_px.at<float>(16, 26), 0.0F);
    EXPECT_GT(num_unknown(), 100) << "of 144";
}

TEST_F(ClosePinholes, AHoleBetweenTwoSurfacesStaysOpen) {
    for (int y = 0; y < disparity_px.rows; ++y)
        for (int x = 0; x < disparity_px.cols; ++x)
            disparity_px.at<float>(y, x) = x < 30 ? 20.0F : 28.0F;
    clear({29, 0, 2, 40});
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(num_unknown(), 80);
}

TEST_F(ClosePinholes, ADisparityThatStandsApartBecomesThatOfTheSurface) {
    disparity_px.at<float>(12, 33) += 5.0F;
    close_pinholes(disparity_px, sigma_px);
    EXPECT_NEAR(disparity_px.at<float>(12, 33), plane(33, 12), 1e-4F);
}

TEST_F(ClosePinholes, AThinBarInFrontOfAWallStays) {
    disparity_px.colRange(30, 33) += 8.0F;
    const cv::Mat before = disparity_px.clone();
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(cv::norm(before, disparity_px, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace divemesh::fusion
