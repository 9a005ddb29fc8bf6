#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// Standard deviation of the image noise in grey values, from the second differences of CV_8UC1
// (Immerkaer 1996, with a low quantile in place of the mean so that texture does not count).
double image_noise(const cv::Mat& image);

// What the texture around each pixel of CV_8UC1 lets a match be known to, px, CV_32F:
// sqrt(2) sigma_n / sqrt(sum of the squared horizontal gradient over the window), noise's own
// gradient taken off, and a floor of 0.15 px beside it. Infinite where there is nothing but noise,
// and within half a window of the border.
cv::Mat disparity_sigma(const cv::Mat& image,
                        base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
