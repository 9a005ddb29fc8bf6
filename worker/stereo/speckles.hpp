#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::stereo {

// Sets islands of less than `min_pixels` connected pixels, neighbours within `max_step_px` of each
// other, to unknown (0). CV_32F disparity, px; <= 0: unknown.
void remove_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px);

// The same, but makes them negative: winners of a matcher that are not confirmed.
void unconfirm_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px);

}  // namespace divemesh::stereo
