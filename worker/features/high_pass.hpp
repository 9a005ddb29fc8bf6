#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::features {

// A filter that removes the local brightness, which caustics, strobes and backscatter change from
// frame to frame: each pixel is taken relative to the mean of its 15 x 15 neighbourhood, with 128
// for 0. Both images CV_8UC1; keeps its buffers between images.
class HighPass {
public:
    void apply(const cv::Mat& image, cv::Mat& result);

private:
    cv::Mat mean_;
};

}  // namespace divemesh::features
