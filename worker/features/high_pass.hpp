#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::features {

// A picture without the brightness of its parts, which caustics, strobes and backscatter move about
// from frame to frame: every pixel against the mean of the 15 x 15 around it, 128 for none. Both
// CV_8UC1; keeps its buffers from picture to picture.
class HighPass {
public:
    void apply(const cv::Mat& image, cv::Mat& result);

private:
    cv::Mat mean_;
};

}  // namespace divemesh::features
