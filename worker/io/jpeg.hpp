#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace divemesh::io {

inline constexpr int kJpegQuality = 90;  // of atlases, 0 to 100

// Returns a BGR image as a JPEG file. Throws Error{Unavailable} if it cannot be encoded.
std::string encode_jpeg(const cv::Mat& image);

}  // namespace divemesh::io
