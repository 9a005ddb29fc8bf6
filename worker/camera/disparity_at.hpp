#pragma once

#include <algorithm>
#include <opencv2/core/mat.hpp>

namespace divemesh::camera {

// Returns the disparity at (u, v), interpolated between the four pixels around it; `nearest` if
// they are not of one surface or not inside the image. Inline: it is called for every pixel.
inline float disparity_at(const cv::Mat& disparity, float u, float v, float nearest) {
    constexpr float kMaxStep_px = 1.0F;  // between neighbours on one surface
    const auto left = static_cast<int>(u);
    const auto top = static_cast<int>(v);
    if (u < 0.0F || v < 0.0F || left + 1 >= disparity.cols || top + 1 >= disparity.rows)
        return nearest;
    const float* above = disparity.ptr<float>(top) + left;
    const float* below = disparity.ptr<float>(top + 1) + left;
    const float min_px = std::min(std::min(above[0], above[1]), std::min(below[0], below[1]));
    const float max_px = std::max(std::max(above[0], above[1]), std::max(below[0], below[1]));
    if (min_px <= 0.0F || max_px - min_px > kMaxStep_px) return nearest;
    const float share = u - static_cast<float>(left);
    const float upper = (1.0F - share) * above[0] + share * above[1];
    const float lower = (1.0F - share) * below[0] + share * below[1];
    const float down = v - static_cast<float>(top);
    return (1.0F - down) * upper + down * lower;
}

}  // namespace divemesh::camera
