#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

namespace divemesh::mosaic {

// Returns an image (CV_8UC4 BGRA) scaled down to `max_side_px` on white, as PNG, for the report.
std::string thumbnail_png(const cv::Mat& color, int max_side_px = 480);

}  // namespace divemesh::mosaic
