#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core/mat.hpp>

namespace divemesh::base {

// Calls visit(pixel, weight) for the four pixels (cv::Point) around a place in an image (centres at
// integers, moved inside), with their weights in bilinear interpolation.
template <typename Visit>
void for_each_bilinear(const cv::Size& size, const Eigen::Vector2f& place, const Visit& visit) {
    const float x = std::clamp(place.x(), 0.0F, static_cast<float>(size.width - 1));
    const float y = std::clamp(place.y(), 0.0F, static_cast<float>(size.height - 1));
    const int column = std::min(static_cast<int>(x), std::max(0, size.width - 2));
    const int row = std::min(static_cast<int>(y), std::max(0, size.height - 2));
    const float right = x - static_cast<float>(column);
    const float below = y - static_cast<float>(row);
    const int next_column = std::min(column + 1, size.width - 1);
    const int next_row = std::min(row + 1, size.height - 1);
    visit(cv::Point(column, row), (1.0F - right) * (1.0F - below));
    visit(cv::Point(next_column, row), right * (1.0F - below));
    visit(cv::Point(column, next_row), (1.0F - right) * below);
    visit(cv::Point(next_column, next_row), right * below);
}

// Returns the colour of an image, CV_8UC3, between its pixels.
inline Eigen::Vector3f bilinear_color(const cv::Mat& image, const Eigen::Vector2f& place) {
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    for_each_bilinear(image.size(), place, [&](const cv::Point& pixel, float weight) {
        const auto& bgr = image.at<cv::Vec3b>(pixel);
        color += weight * Eigen::Vector3f(bgr[0], bgr[1], bgr[2]);
    });
    return color;
}

}  // namespace divemesh::base
