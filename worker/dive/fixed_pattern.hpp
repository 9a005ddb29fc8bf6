#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::dive {

// Finds what stays in place in the images of a dive while the scene moves on: an overlay that the
// camera burnt in, such as time and depth, or a part of the rig in view. It is where edges of the
// mean image hardly change from frame to frame.
class FixedPattern {
public:
    void add(const cv::Mat& image);  // 8 bit grey, all of one size

    // Returns a mask that is 255 around fixed edges; empty if there are too few of them, if there
    // are too few images, or if most of the scene stands still too.
    cv::Mat mask() const;

private:
    cv::Mat sum_;
    cv::Mat sum_of_squares_;
    int num_images_ = 0;
};

}  // namespace divemesh::dive
