#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::stereo {

// The definition of CensusSgm over whole cost volumes, pixel by pixel in plain integers: slow, and
// without a line in common with the kernels. Negative: of a winner that a check did not confirm.
cv::Mat reference_sgm(const cv::Mat& left, const cv::Mat& right, int num_disparities);

}  // namespace divemesh::stereo
