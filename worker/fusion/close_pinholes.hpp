#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::fusion {

// Closes holes of up to 3 px in a disparity map, and replaces single disparities that stand
// apart from the surface around them. Both kinds come from noise and would widen to holes of
// several voxels. A disparity stands apart if at most two of its neighbours are within a pixel of
// it. A pixel of a hole is closed if surface lies on both sides along three of four directions,
// within 3 px, and all of them agree on one disparity. The pixel gets their mean and the largest of
// their sigmas. Both maps are CV_32F of one size; disparity 0: unknown.
void close_pinholes(cv::Mat& disparity_px, cv::Mat& sigma_px);

}  // namespace divemesh::fusion
