#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// Raises each sigma (CV_32F, px) by the share of the winners within 9 x 9 px that are unconfirmed
// (<= 0) or lie at a step of the disparity: the windows of such a pixel hold more than one surface,
// which the residuals of one of them do not show.
void add_doubt(const cv::Mat& winners_px,
               cv::Mat& sigma_px,
               base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
