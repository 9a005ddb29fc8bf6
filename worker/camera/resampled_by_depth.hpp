#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/camera/disparity_at.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::camera {

// Returns 0 if the pixel is outside of the image or has no disparity.
inline float nearest_disparity(const cv::Mat& disparity, float u, float v) {
    const auto column = static_cast<int>(std::lround(u));
    const auto row = static_cast<int>(std::lround(v));
    if (column < 0 || row < 0 || column >= disparity.cols || row >= disparity.rows) return 0.0F;
    return disparity.at<float>(row, column);
}

// Returns the left image and depth resampled by shifts that depend on the depth.
// `shift_at(u, v, x, y, disparity_px)` returns what is added to (u, v, disparity) of a pixel of the
// result for the source, which is near (x, y) and has that disparity. Both are those of the
// result's pixel in the first of `num_iterations`, which suffices for shifts of less than a pixel.
// A pixel without disparity moves as one with the mean of the others; images without any stay.
template <typename ShiftAt>
types::KeyframeImages resampled_by_depth(const types::KeyframeImages& images,
                                         int num_iterations,
                                         const ShiftAt& shift_at) {
    const cv::Mat& disparity = images.depth.disparity_px;
    const float mean_px =
        disparity.empty() ? 0.0F : static_cast<float>(cv::mean(disparity, disparity > 0.0)[0]);
    if (mean_px <= 0.0F) return images;
    types::KeyframeImages result;
    result.depth.disparity_px = cv::Mat::zeros(disparity.size(), CV_32F);
    result.depth.sigma_disparity_px = cv::Mat::zeros(disparity.size(), CV_32F);
    cv::Mat source_x(disparity.size(), CV_32F);
    cv::Mat source_y(disparity.size(), CV_32F);
    for (int v = 0; v < disparity.rows; ++v) {
        for (int u = 0; u < disparity.cols; ++u) {
            float& x = source_x.at<float>(v, u);
            float& y = source_y.at<float>(v, u);
            x = static_cast<float>(u);
            y = static_cast<float>(v);
            float seen_px = 0.0F;
            float shift_px = 0.0F;  // of the disparity
            for (int i = 0; i < num_iterations; ++i) {
                const float known_px = nearest_disparity(disparity, x, y);
                const Eigen::Vector3f shift =
                    shift_at(u, v, x, y, known_px > 0.0F ? known_px : mean_px);
                x = static_cast<float>(u) + shift.x();
                y = static_cast<float>(v) + shift.y();
                seen_px = nearest_disparity(disparity, x, y);
                shift_px = shift.z();
            }
            if (seen_px <= 0.0F) continue;
            const float moved_px = disparity_at(disparity, x, y, seen_px) - shift_px;
            if (moved_px <= 0.0F) continue;
            result.depth.disparity_px.at<float>(v, u) = moved_px;
            result.depth.sigma_disparity_px.at<float>(v, u) =
                nearest_disparity(images.depth.sigma_disparity_px, x, y);
        }
    }
    if (!images.left_color.empty())
        cv::remap(images.left_color, result.left_color, source_x, source_y, cv::INTER_LINEAR);
    return result;
}

}  // namespace divemesh::camera
