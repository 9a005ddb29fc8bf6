#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/instructions.hpp"

namespace divemesh::worker {

// Sub-pixel disparity without pixel locking. The winners of a matcher crowd at whole pixels; a
// Lucas-Kanade step of each pixel alone would keep its noise. So: smooth on the local plane, one
// step over a window in which every pixel keeps its own disparity (gain and bias between the
// cameras are estimated with it), smooth again, farther around where the step left it uncertain.
// CV_8UC1 images, CV_32F disparity, 0: unknown. Returns the standard deviation, px, CV_32F: of the
// least squares, from what they leave unexplained. Where that is no better than noise would have
// it, the disparity becomes unknown.
cv::Mat refine_disparity(const cv::Mat& left,
                         const cv::Mat& right,
                         cv::Mat& disparity_px,
                         Instructions instructions = best_instructions());

// Mean of those pairs of opposite neighbours within 2 px whose own mean is within `gate_px` of the
// centre: planes of any slant stay as they are, edges stay sharp.
cv::Mat smooth_on_plane(const cv::Mat& disparity_px,
                        float gate_px,
                        Instructions instructions = best_instructions());

// Gives unknown pixels the mean of their opposite neighbours where at least three pairs of the
// eight around are known and agree: what the checks of a matcher took out of a surface one by one.
void fill_pinholes(cv::Mat& disparity_px);

}  // namespace divemesh::worker
