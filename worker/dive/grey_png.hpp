#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string_view>

namespace divemesh::dive {

// The commonest picture of a recording, a PNG of 8 bits grey without interlace, in half of libpng's
// time: libdeflate unpacks it in one piece. Nothing for any other PNG and for one that is damaged
// in any way; the caller then asks OpenCV.
std::optional<cv::Mat> decode_grey_png(std::string_view bytes);

}  // namespace divemesh::dive
