#pragma once

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

namespace divemesh::base {

// Where rectangles are on sheets.
struct RectanglePacking {
    std::vector<cv::Size> sheets;
    std::vector<std::int32_t> sheet_of;  // one per rectangle
    std::vector<cv::Point> corners;      // one per rectangle, the upper left on its sheet
};

// Packs rectangles, the highest first, by the skyline method (Jylaenki, "A thousand ways to pack
// the bin", 2010): sheets are about square, and as many as needed. Throws Error{InvalidArgument} if
// a rectangle is empty or larger than a sheet may be.
RectanglePacking pack_rectangles(const std::vector<cv::Size>& rectangles, int max_side_px);

}  // namespace divemesh::base
