#pragma once

#include <opencv2/core/mat.hpp>
#include <span>

#include "worker/stereo/neighbour_view.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::stereo {

// Measures depth where one pair could not: what one eye alone sees, and texture that only more
// views and a wider baseline resolve. Planes spread from the measured surface into the holes and
// are improved there (PatchMatch stereo: Bleyer, Rhemann and Rother 2011; across frames: Galliani,
// Lasinger and Schindler 2015). The score of a plane is the correlation of the window around the
// pixel with what the best two neighbours show of it. A depth is accepted if
// - two neighbours show it with a correlation of 0.8 or more,
// - it is a peak: 1 px further along the neighbours' epipolar lines the correlation is lower, and
// - it is connected with enough others.
// Its sigma is that of the peak. Works at a reduced size of about 400 px of width; what the pair
// measured stays as it is. Returns the number of pixels filled. The poses must be exact to a pixel.
int fill_from_views(const types::RectifiedRig& rig,
                    const cv::Mat& left,
                    std::span<const NeighbourView> neighbours,
                    types::DepthMap& depth);

}  // namespace divemesh::stereo
