#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string_view>

namespace divemesh::dive {

// Decodes an 8-bit grey PNG without interlace, the most common image format of recordings, in half
// of libpng's time: libdeflate decompresses it in one call. Returns nullopt for any other or
// damaged PNG; the caller then uses OpenCV.
std::optional<cv::Mat> decode_grey_png(std::string_view bytes);

}  // namespace divemesh::dive
