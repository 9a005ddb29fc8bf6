#include "worker/recording/fast_png.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

namespace divemesh::recording {
namespace {

cv::Mat decoded(const std::string& png) {
    return cv::imdecode(std::vector<unsigned char>(png.begin(), png.end()),
                        cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
}

TEST(FastPngTest, LibpngReadsThePixelsThatWereWritten) {
    cv::theRNG().state = 7;
    for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3, CV_16UC3})
        for (const cv::Size& size : {cv::Size(1, 1), cv::Size(1, 40), cv::Size(333, 17)}) {
            cv::Mat image(size, type);
            cv::randu(image, 0, 65536);
            const cv::Mat before = image.clone();
            const cv::Mat read = decoded(fast_png(image));
            EXPECT_EQ(cv::norm(image, before, cv::NORM_INF), 0.0) << "the image itself changed";
            ASSERT_EQ(read.type(), type);
            ASSERT_EQ(read.size(), size);
            EXPECT_EQ(cv::norm(read, image, cv::NORM_INF), 0.0) << type << ' ' << size;
        }
}

TEST(FastPngTest, APartOfAnImageIsWrittenWithoutItsSurroundings) {
    cv::Mat image(60, 80, CV_8UC3);
    cv::randu(image, 0, 256);
    const cv::Mat part = image(cv::Rect(5, 6, 31, 20));
    EXPECT_EQ(cv::norm(decoded(fast_png(part)), part, cv::NORM_INF), 0.0);
}

TEST(FastPngTest, WhatIsSmoothIsSmall) {
    cv::Mat image(480, 640, CV_8UC1);
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
            image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>((x + y) / 5);
    EXPECT_LT(fast_png(image).size(), image.total() / 10);
}

}  // namespace
}  // namespace divemesh::recording
