#pragma once

#include <algorithm>

namespace divemesh::types {

// The disparities that a matcher searches: first_px, first_px + 1, ..., `num_px` of them.
struct DisparityRange {
    int first_px = 0;
    int num_px = 0;
};

inline constexpr int kMaxDisparities = 512;  // of any search at full size
inline constexpr int kLargeWidth_px = 832;   // wider images are searched farther

// Returns how many disparities are searched at most in an image of a width, where something may be
// near: as many as asked for, and in images of more than 832 px at least 27 % of the width, up to
// 512. The nearest surface is then as near in large images as in small ones.
inline int max_disparities_px(int num_disparities_px, int width_px) {
    constexpr double kShareOfWidth = 0.27;
    constexpr int kStep_px = 64;
    if (width_px <= kLargeWidth_px) return num_disparities_px;
    const int wide = static_cast<int>(kShareOfWidth * width_px) / kStep_px * kStep_px;
    return std::max(num_disparities_px, std::min(kMaxDisparities, wide));
}

}  // namespace divemesh::types
