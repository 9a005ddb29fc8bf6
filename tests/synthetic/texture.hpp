#pragma once

#include <cmath>
#include <numbers>
#include <opencv2/core/mat.hpp>

namespace divemesh::synthetic {

// Returns a smooth texture without repetition, known exactly everywhere: the sum of waves of many
// lengths and directions.
inline double texture(double x, double y) {
    double sum = 0.0;
    for (int i = 0; i < 32; ++i) {
        const double direction = 2.399963 * i;  // the golden angle
        const double length_px = 8.0 + 1.7 * i;
        const double phase = (x * std::cos(direction) + y * std::sin(direction)) / length_px;
        sum += 7.0 * std::sin(2.0 * std::numbers::pi * phase + 1.3 * i * i);
    }
    return sum;
}

// Returns an image of the texture moved by (dx, dy), with changed contrast and brightness.
inline cv::Mat textured_image(double dx,
                              double dy,
                              double contrast = 1.0,
                              double brightness = 128.0) {
    cv::Mat image(240, 320, CV_8U);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u)
            image.at<unsigned char>(v, u) = cv::saturate_cast<unsigned char>(
                std::lround(brightness + contrast * texture(u - dx, v - dy)));
    return image;
}

}  // namespace divemesh::synthetic
