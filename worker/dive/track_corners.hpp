#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace divemesh::dive {

// Returns where the points of `from` are in `to`. Clears `found` for those that do not track back
// to their start.
std::vector<cv::Point2f> track_corners(const cv::Mat& from,
                                       const cv::Mat& to,
                                       const std::vector<cv::Point2f>& points,
                                       std::vector<bool>& found);

}  // namespace divemesh::dive
