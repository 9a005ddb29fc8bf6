#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/types/keyframe.hpp"

namespace divemesh::stereo {

// A pair as the matcher compares it: smoothed where noise would hide its texture.
struct MatchingImages {
    cv::Mat left;       // CV_8UC1
    cv::Mat right;      // CV_8UC1
    int tolerance = 1;  // differences of grey value that count as noise, see CensusSgm
};

// Returns the images for matching, by the noise of the left one.
MatchingImages matching_images(const types::RectifiedFrame& frame);

}  // namespace divemesh::stereo
