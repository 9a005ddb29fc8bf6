#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// Step 1 at the features alone: sub-pixel disparity by looking for each one's patch along its row
// of the right picture. A feature whose disparity_px is > 0 is looked for there first; where
// `dense_px` (CV_32F, may be empty) knows the disparity, there. What is not found, or found better
// or as well elsewhere, comes back with disparity 0.
void match_sparse_stereo(const types::RectifiedFrame& frame,
                         const cv::Mat& dense_px,
                         int num_disparities_px,
                         types::Features& features);

}  // namespace divemesh::features
