#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::camera {

// Returns the slope of a grey image, grey values per px (CV_32F), by Sobel's operator of 3 x 3.
cv::Mat gradient_magnitude(const cv::Mat& grey);

}  // namespace divemesh::camera
