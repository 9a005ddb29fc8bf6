#include "worker/camera/view_details.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace divemesh::camera {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;

// A scene wider than the image, with details of about 8 px.
cv::Mat scene() {
    cv::Mat noise(kHeight_px, 2 * kWidth_px, CV_32F);
    cv::RNG(7).fill(noise, cv::RNG::NORMAL, 0.0, 300.0);
    cv::GaussianBlur(noise, noise, {}, 4.0);
    return noise + 120.0;
}

// The image of the scene by a camera that moved to the right.
cv::Mat image_from(int moved_px) {
    cv::Mat image;
    scene()(cv::Rect(moved_px, 0, kWidth_px, kHeight_px)).convertTo(image, CV_8U);
    return image;
}

// Light that plays over an image: waves of 200 px whose crests move with the phase.
cv::Mat under_waves(const cv::Mat& image, double phase) {
    cv::Mat lit = image.clone();
    for (int row = 0; row < lit.rows; ++row)
        for (int column = 0; column < lit.cols; ++column) {
            const double wave =
                std::sin(2.0 * std::numbers::pi * (column + 0.5 * row) / 200.0 + phase);
            lit.at<uchar>(row, column) =
                cv::saturate_cast<uchar>(image.at<uchar>(row, column) * (1.0 + 0.4 * wave));
        }
    return lit;
}

bool are_one_view(const cv::Mat& first, const cv::Mat& second) {
    return is_same_view(view_details(small_view(first)), view_details(small_view(second)));
}

TEST(ViewDetailsTest, ACameraThatMovedHasAnotherView) {
    EXPECT_TRUE(are_one_view(image_from(0), image_from(0)));
    for (const int moved_px : {24, 40, 100, 300, 600})
        EXPECT_FALSE(are_one_view(image_from(0), image_from(moved_px))) << moved_px << " px";
}

TEST(ViewDetailsTest, LightThatPlaysOverTheSceneLeavesTheView) {
    for (const double phase : {0.5, 1.5, 3.1})
        EXPECT_TRUE(
            are_one_view(under_waves(image_from(0), 0.0), under_waves(image_from(0), phase)))
            << phase;
}

TEST(ViewDetailsTest, WhatCoversTwoFifthsLeavesTheViewAndThreeFifthsDoNot) {
    for (const double share : {0.4, 0.6}) {
        cv::Mat covered = image_from(0);
        const cv::Rect part(0, 0, static_cast<int>(share * kWidth_px), kHeight_px);
        image_from(300)(part).copyTo(covered(part));
        EXPECT_EQ(are_one_view(image_from(0), covered), share < 0.5) << share;
    }
}

TEST(ViewDetailsTest, OpenWaterTellsOfNoMotion) {
    const cv::Mat water(kHeight_px, kWidth_px, CV_8UC1, cv::Scalar(90));
    EXPECT_TRUE(are_one_view(water, water));
    EXPECT_FALSE(are_one_view(water, image_from(0)));
}

TEST(ViewDetailsTest, ASmallImageKeepsItsSize) {
    EXPECT_EQ(small_view(image_from(0)).size(), cv::Size(160, 120));
    EXPECT_EQ(small_view(cv::Mat(60, 80, CV_8UC1, cv::Scalar(5))).size(), cv::Size(80, 60));
}

}  // namespace
}  // namespace divemesh::camera
