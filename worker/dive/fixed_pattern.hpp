#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace divemesh::dive {

// Finds what stays in place in the images of a dive while the scene moves on: an overlay that the
// camera burnt in, such as time and depth, a part of the rig in view, or the border between a round
// image and the black around it. The pattern is where edges of the mean image hardly change from
// frame to frame.
class FixedPattern {
public:
    // Masks (CV_8U); 255 where something stays in place. An empty one has too few such pixels.
    struct Masks {
        cv::Mat overlay;  // around text and parts of the rig
        cv::Mat border;   // the black surroundings, and a rim around them

        // Returns both in one mask.
        cv::Mat all() const;
    };

    void add(const cv::Mat& image);  // 8 bit grey, all of one size

    // Returns empty masks if there are too few images or if the rig stands still. It stands still
    // if most edges all over the image stay, even while something such as a shoal passes. There is
    // no overlay mask if most images show one view: what stays may be the scene of a long rest.
    Masks masks() const;

private:
    bool most_edges_stay() const;
    bool most_show_one_view() const;

    cv::Mat sum_;
    cv::Mat sum_of_squares_;
    std::vector<cv::Mat> small_;    // CV_32F, each image reduced
    std::vector<cv::Mat> details_;  // of each image
    int num_images_ = 0;
};

}  // namespace divemesh::dive
