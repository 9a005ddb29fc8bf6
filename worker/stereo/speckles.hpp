#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::stereo {

// Sets islands of fewer than `min_pixels` connected pixels to unknown (0). Neighbours are connected
// if they differ by at most `max_step_px`. CV_32F disparity, px; <= 0: unknown.
void remove_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px);

// The same, but makes them negative, i.e. unconfirmed winners of a matcher.
void unconfirm_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px);

}  // namespace divemesh::stereo
