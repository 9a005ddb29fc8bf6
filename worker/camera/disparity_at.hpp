#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::camera {

// Returns the disparity at (u, v), interpolated between the four pixels around it; `nearest` if
// they are not of one surface or not inside the image.
float disparity_at(const cv::Mat& disparity, float u, float v, float nearest);

}  // namespace divemesh::camera
