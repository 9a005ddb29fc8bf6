#pragma once

#include "worker/types/disparity_range.hpp"
#include "worker/types/feature.hpp"

namespace divemesh::stereo {

// Step 1: returns the disparity search range of the dense search in a frame: from the min to the
// max disparity of its features, extended to depths a quarter nearer and a third farther for the
// surface between them. It is a multiple of 64, so that vectors of every instruction set are full.
// Returns all that may be searched in an image of the width, types::max_disparities_px(), if the
// range would be as large. Few features do not show how near the scene is: then it is all of
// `num_disparities_px`, also in a large image.
types::DisparityRange disparity_search_range(const types::Features& features,
                                             int num_disparities_px,
                                             int width_px);

}  // namespace divemesh::stereo
