#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace divemesh::base {

// Gives each pixel that is not 0 in `is_uncovered` (CV_8UC1) the value of the nearest one that is.
template <typename Pixel>
void extend_pixels(const cv::Mat& is_uncovered, cv::Mat& values) {
    cv::Mat distances;
    cv::Mat nearest;
    cv::distanceTransform(
        is_uncovered, distances, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
    std::vector<Pixel> of_label(values.total() + 1);
    for (int row = 0; row < values.rows; ++row)
        for (int column = 0; column < values.cols; ++column)
            if (is_uncovered.at<std::uint8_t>(row, column) == 0)
                of_label[nearest.at<int>(row, column)] = values.at<Pixel>(row, column);
    for (int row = 0; row < values.rows; ++row)
        for (int column = 0; column < values.cols; ++column)
            values.at<Pixel>(row, column) = of_label[nearest.at<int>(row, column)];
}

}  // namespace divemesh::base
