#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/stereo/padded_disparity.hpp"
#include "worker/stereo/subpixel_refinement.hpp"

namespace divemesh::stereo {

// Sub-pixel disparity without pixel locking. The winners of a matcher crowd at whole pixels; a
// Lucas-Kanade step of each pixel alone would keep its noise. So: fill the holes that the winners
// themselves support, smooth on the local plane, one step over a window, smooth again, farther
// around where the step left it uncertain.
class DisparityRefiner {
public:
    explicit DisparityRefiner(base::Instructions instructions = base::best_instructions())
        : instructions_(instructions), step_(instructions) {}

    // CV_8UC1 pictures, CV_32F disparity, 0: unknown, negative: of a winner that a check did not
    // confirm. Returns the standard deviation, px, CV_32F: of the least squares, from what they
    // leave unexplained. Where that is no better than noise would have it, the disparity becomes
    // unknown, as it does where nothing supports an unconfirmed one.
    cv::Mat refine(const cv::Mat& left, const cv::Mat& right, cv::Mat& disparity_px);

private:
    base::Instructions instructions_;
    SubpixelRefinement step_;
    PaddedDisparity one_px_;
    PaddedDisparity other_px_;
    PaddedDisparity sigma_px_;
    PaddedDisparity smooth_sigma_px_;
};

}  // namespace divemesh::stereo
