#include "worker/io/half_size.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::io {
namespace {

TEST(HalfSizeTest, HeightsAreTheMeanOfThoseThatAreKnown) {
    const float no = std::nanf("");
    const cv::Mat heights = (cv::Mat_<float>(3, 5) << 1,
                             2,
                             no,
                             no,
                             7,  //
                             3,
                             4,
                             no,
                             no,
                             8,  //
                             5,
                             no,
                             6,
                             2,
                             9);
    const cv::Mat half = half_size(heights);

    ASSERT_EQ(half.size(), cv::Size(3, 2));
    EXPECT_EQ(half.at<float>(0, 0), 2.5F);
    EXPECT_TRUE(std::isnan(half.at<float>(0, 1)));
    EXPECT_EQ(half.at<float>(0, 2), 7.5F);
    EXPECT_EQ(half.at<float>(1, 0), 5.0F);
    EXPECT_EQ(half.at<float>(1, 1), 4.0F);
    EXPECT_EQ(half.at<float>(1, 2), 9.0F);
}

TEST(HalfSizeTest, ColoursAreTheMeanOfThosePixelsThatShowSurface) {
    cv::Mat color(2, 4, CV_8UC4, cv::Scalar::all(0));
    color.at<cv::Vec4b>(0, 0) = {10, 20, 30, 255};
    color.at<cv::Vec4b>(1, 1) = {20, 40, 61, 255};
    const cv::Mat half = half_size(color);

    ASSERT_EQ(half.size(), cv::Size(2, 1));
    EXPECT_EQ(half.at<cv::Vec4b>(0, 0), cv::Vec4b(15, 30, 46, 255));
    EXPECT_EQ(half.at<cv::Vec4b>(0, 1), cv::Vec4b());
}

}  // namespace
}  // namespace divemesh::io
