#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::bench {

inline constexpr int kWidth_px = 640;
inline constexpr int kHeight_px = 480;

struct ImagePair {
    cv::Mat left;
    cv::Mat right;
};

// A slanted bed of random texture, about 20 to 60 px near, with other noise in each picture.
const ImagePair& slanted_bed();

}  // namespace divemesh::bench
