#pragma once

#include "worker/types/disparity_range.hpp"
#include "worker/types/feature.hpp"

namespace divemesh::stereo {

// Step 1: where the dense search looks in a frame. From the least to the largest disparity of its
// features, and a quarter nearer and a third farther, as the surface between them may be; in steps
// of 64, so that no vector of any instruction set is half empty. All of `num_disparities_px` where
// that is no less, or where features are few.
types::DisparityRange disparity_search_range(const types::Features& features,
                                             int num_disparities_px);

}  // namespace divemesh::stereo
