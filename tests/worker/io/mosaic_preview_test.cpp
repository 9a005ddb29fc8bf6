#include "worker/io/mosaic_preview.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace divemesh::io {
namespace {

const cv::Vec4b kDark(10, 20, 30, 255);
const cv::Vec4b kLight(50, 60, 70, 255);

TEST(MosaicPreviewTest, APixelIsTheMeanOfThoseThatShowSurface) {
    const types::RasterGrid whole{7, 5, 0.001, 3.0, 4.0};
    cv::Mat color(5, 7, CV_8UC4, cv::Scalar::all(0));
    color.at<cv::Vec4b>(0, 0) = kDark;
    color.at<cv::Vec4b>(1, 1) = kLight;
    color.at<cv::Vec4b>(4, 6) = kLight;  // alone in the last, incomplete square
    MosaicPreview preview(whole, 4);
    preview.append(color.rowRange(0, 1));
    preview.append(color.rowRange(1, 5));

    EXPECT_EQ(preview.grid().width_px, 4);
    EXPECT_EQ(preview.grid().height_px, 3);
    EXPECT_DOUBLE_EQ(preview.grid().pixel_m, 0.002);
    EXPECT_DOUBLE_EQ(preview.grid().corner_x_m, 3.0);
    EXPECT_DOUBLE_EQ(preview.grid().corner_y_m, 4.0);
    ASSERT_EQ(preview.image().size(), cv::Size(4, 3));
    EXPECT_EQ(preview.image().at<cv::Vec4b>(0, 0), cv::Vec4b(30, 40, 50, 255));
    EXPECT_EQ(preview.image().at<cv::Vec4b>(0, 1), cv::Vec4b());
    EXPECT_EQ(preview.image().at<cv::Vec4b>(2, 3), kLight);
}

TEST(MosaicPreviewTest, ASmallMosaicIsItsOwnPreview) {
    cv::Mat color(3, 4, CV_8UC4, cv::Scalar(kDark));
    MosaicPreview preview({4, 3, 0.5, 0.0, 0.0}, 4096);
    preview.append(color);

    EXPECT_EQ(preview.grid().pixel_m, 0.5);
    EXPECT_EQ(cv::norm(preview.image(), color, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace divemesh::io
