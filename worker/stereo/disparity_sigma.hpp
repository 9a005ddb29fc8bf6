#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// Returns the standard deviation of the image noise in grey values, from the second differences of
// CV_8UC1 (Immerkaer 1996, with a low quantile instead of the mean, so that texture does not
// count) around pixels that are not clipped to black or white.
double image_noise(const cv::Mat& image);

// Returns the standard deviation of a match at each pixel of CV_8UC1 given the texture around it,
// px, CV_32F: sqrt(2) sigma_n / sqrt(sum of the squared horizontal gradient over the window),
// without the gradient of the noise, and combined with a floor of 0.15 px. Infinite where there is
// only noise, and within half a window of the border.
cv::Mat disparity_sigma(const cv::Mat& image,
                        base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
