#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace divemesh::io {

inline constexpr int kJpegQuality = 90;  // of atlases, 0 to 100

// Returns a BGR image as a JPEG file. Throws Error{Unavailable} if it cannot be encoded.
std::string encode_jpeg(const cv::Mat& image, int quality = kJpegQuality);

// Returns the size that a JPEG file states in its frame header (ITU-T T.81); nullopt if it has
// none.
std::optional<cv::Size> jpeg_size(std::string_view jpeg);

// Returns the image of a JPEG file, CV_8UC3 BGR; empty if it cannot be read.
cv::Mat decode_jpeg(std::string_view jpeg);

}  // namespace divemesh::io
