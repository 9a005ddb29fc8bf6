#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/base/instructions.hpp"

namespace divemesh::fusion {

// Sets `rim_px` to 0 at the pixels of bridges: disparities between a near surface and a farther one
// behind its edge. Windows that show both measure them, and smoothing spreads the step over some
// pixels, so that it is no discontinuity. Surface is nowhere along them, and at a grazing angle a
// few pixels span more than a decimetre. A pixel is on a bridge if, along a row or a column, the
// disparity from 4 px before it to 4 px behind it
//
// - changes 1.5 times as fast as within the 6 px on either side,
// - belongs to a surface that is seen at less than some 14 degrees, and
// - changes by more than five standard deviations.
//
// The real face of a step that is so narrow and seen at such an angle goes too; a view that sees it
// better measures it better. Where one of the disparities is unknown, nothing is said. All maps are
// CV_32F of one size; disparity 0: unknown.
void mark_bridges(const cv::Mat& disparity_px,
                  const cv::Mat& sigma_px,
                  double focal_px,
                  base::Instructions instructions,
                  cv::Mat& rim_px);

}  // namespace divemesh::fusion
