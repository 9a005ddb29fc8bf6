#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::bench {

inline constexpr int kWidth_px = 640;
inline constexpr int kHeight_px = 480;

struct ImagePair {
    cv::Mat left;
    cv::Mat right;
};

// Returns a pair of images of a slanted bed with random texture. Disparities are about 20 to 60 px,
// and each image has its own noise.
const ImagePair& slanted_bed();

}  // namespace divemesh::bench
