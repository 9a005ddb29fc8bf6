#include "worker/mosaic/thumbnail.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <vector>

namespace divemesh::mosaic {
namespace {

TEST(ThumbnailTest, IsSmallAndWhiteWhereThereIsNothing) {
    cv::Mat color(1000, 800, CV_8UC4, cv::Scalar(50, 50, 50, 255));
    color(cv::Rect(400, 0, 400, 500)) = cv::Scalar::all(0);
    const std::string png = thumbnail_png(color, 100);
    const cv::Mat image = cv::imdecode(std::vector<char>(png.begin(), png.end()), cv::IMREAD_COLOR);
    ASSERT_EQ(image.size(), cv::Size(80, 100));
    EXPECT_EQ(image.at<cv::Vec3b>(10, 70), cv::Vec3b(255, 255, 255));
    EXPECT_EQ(image.at<cv::Vec3b>(90, 10), cv::Vec3b(50, 50, 50));
}

}  // namespace
}  // namespace divemesh::mosaic
