#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <string>

namespace divemesh::io {

// Returns a tile as a TIFF stores it: CV_8UC4 (BGRA) as RGBA with the horizontal predictor, CV_32F
// with that of floating point, then deflated.
std::string packed_tile(const cv::Mat& tile);

}  // namespace divemesh::io
