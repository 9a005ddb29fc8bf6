#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::boards {

// Moves a point to the saddle of brightness next to it, where two black and two white areas meet,
// by a window of that half size (2 to 10 px). Returns false if there is none.
bool move_to_saddle(const cv::Mat& image, double half_px, cv::Point2f& point);

}  // namespace divemesh::boards
