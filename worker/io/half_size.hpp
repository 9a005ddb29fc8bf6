#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::io {

// Returns a raster of half the size, rounded up, for overviews. A pixel is the mean of the up to
// four that it covers and that are known: alpha (CV_8UC4) is not 0, a CV_32F is not NaN. It is
// unknown where all of them are.
cv::Mat half_size(const cv::Mat& raster);

}  // namespace divemesh::io
