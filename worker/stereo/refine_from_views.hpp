#pragma once

#include <opencv2/core/mat.hpp>
#include <span>

#include "worker/base/instructions.hpp"
#include "worker/stereo/neighbour_view.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::stereo {

// EveryPixel: each is measured by itself. Grid: one of four (of 16 in images above 832 px), those
// between take what the grid says; a quarter of the time.
enum class Density { Grid, EveryPixel };

// Improves the disparities of a pair by the frames around it, whose baselines are longer: Lucas and
// Kanade's alignment of the window around a pixel with each neighbour, along its epipolar line
// (Gauss-Newton over the disparity, all neighbours at once, gain and bias free). What the
// neighbours say is averaged with what the pair said, weighted by the variances; where the two
// differ by more than three standard deviations the pair's stays. Pixels without disparity stay
// without. The poses must be exact to a fraction of a pixel. Returns the number of pixels that were
// improved.
int refine_from_views(const types::RectifiedRig& rig,
                      const cv::Mat& left,
                      std::span<const NeighbourView> neighbours,
                      Density density,
                      types::DepthMap& depth,
                      base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
