#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::stereo {

// Returns the disparities by the definition of CensusSgm, over whole cost volumes, pixel by pixel
// in plain integers. It is slow and shares no code with the kernels. A disparity is negative where
// a check did not confirm the winner.
cv::Mat reference_sgm(const cv::Mat& left,
                      const cv::Mat& right,
                      int num_disparities,
                      int tolerance);

}  // namespace divemesh::stereo
