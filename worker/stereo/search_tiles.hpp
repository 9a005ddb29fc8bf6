#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "worker/types/disparity_range.hpp"

namespace divemesh::stereo {

// A part of the left image and the disparities that are searched there.
struct SearchTile {
    cv::Rect part;
    types::DisparityRange range;
};

// Returns tiles that cover an image of a size, each with the part of `range` that the disparities
// of its surroundings at half the size leave (CV_32F, px of the half size; 0: unknown). A tile of
// which the half size knows little keeps the whole range. Returns one tile with the whole range
// where tiles would cost about as much.
std::vector<SearchTile> search_tiles(const cv::Mat& half_disparity_px,
                                     cv::Size size,
                                     const types::DisparityRange& range);

// Returns a part with the surroundings whose path costs it needs: those that reach it from beyond
// are settled then.
cv::Rect with_surroundings(const cv::Rect& part, cv::Size size);

}  // namespace divemesh::stereo
