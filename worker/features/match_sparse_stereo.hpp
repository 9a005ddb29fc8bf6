#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// Step 1 at the features alone: sets their sub-pixel disparity by searching each patch along its
// row in the right image. The search starts at the feature's disparity if it is > 0, or at that of
// `dense_px` (CV_32F, may be empty) if known. The disparity is 0 if the patch is not found or fits
// elsewhere as well.
void match_sparse_stereo(const types::RectifiedFrame& frame,
                         const cv::Mat& dense_px,
                         int num_disparities_px,
                         types::Features& features);

}  // namespace divemesh::features
