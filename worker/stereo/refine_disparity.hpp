#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/stereo/padded_disparity.hpp"
#include "worker/stereo/subpixel_refinement.hpp"

namespace divemesh::stereo {

// Sub-pixel refinement without pixel locking. A matcher's winners cluster at whole pixels, and a
// Lucas-Kanade step of each pixel alone would keep its noise. So the refiner fills the holes that
// the winners support, smooths on the local plane, does one step over a window, and smooths again,
// with a wider reach where the step is uncertain.
class DisparityRefiner {
public:
    explicit DisparityRefiner(base::Instructions instructions = base::best_instructions())
        : instructions_(instructions), step_(instructions) {}

    // Refines `disparity_px` (CV_32F, 0: unknown, negative: an unconfirmed winner) of a pair
    // (CV_8UC1). Returns the standard deviation, px, CV_32F, from the residuals of the least
    // squares. The disparity becomes unknown where that is no better than noise, or where an
    // unconfirmed winner has no support.
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
