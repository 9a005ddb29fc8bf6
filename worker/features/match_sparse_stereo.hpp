#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// Step 1 at the features alone: sets their sub-pixel disparity by searching each patch along its
// row in the right image. If `dense_px` (CV_32F) is not empty, its disparity is refined; else the
// search tries the feature's own disparity first, if it is > 0. In images of more than 832 px a
// feature without a disparity is searched over types::max_disparities_px(), one with a disparity no
// farther than a third nearer than that, or over `num_disparities_px`. The disparity is 0 if the
// patch is not found or fits elsewhere as well.
void match_sparse_stereo(const types::RectifiedFrame& frame,
                         const cv::Mat& dense_px,
                         int num_disparities_px,
                         types::Features& features);

}  // namespace divemesh::features
