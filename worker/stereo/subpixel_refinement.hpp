#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/base/instructions.hpp"
#include "worker/stereo/lucas_kanade_terms.hpp"
#include "worker/stereo/padded_disparity.hpp"

namespace divemesh::stereo {

// Sigma of a disparity refined by the wide window, which measures only the common error of its
// disparities. Each single one is still as uncertain as a matcher's winner with little texture, and
// its neighbours with it.
inline constexpr float kWideSigma_px = 1.0F;

// One Lucas-Kanade step of the disparities over a window of 9 x 9 px, in which every pixel keeps
// its own disparity. Gain and bias between the cameras are estimated too. Windows with too little
// texture grow to 27 x 27 px.
class SubpixelRefinement {
public:
    explicit SubpixelRefinement(base::Instructions instructions)
        : instructions_(instructions), terms_(instructions) {}

    // Applies the step to `disparity_px`; images are CV_8UC1, larger than 8 x 8 px. `sigma_px` is
    // the standard deviation from the residuals of the least squares; 0: even the wide window shows
    // hardly more than noise.
    void take(const cv::Mat& left,
              const cv::Mat& right,
              PaddedDisparity& disparity_px,
              PaddedDisparity& sigma_px);

private:
    // By block of 9 x 9 px, with one unused block all around.
    struct Blocks {
        int stride = 0;
        std::vector<float> sums[kNumTerms];
        std::vector<float> step_px;
        std::vector<float> sigma_px;
    };

    void begin_blocks(cv::Size size);
    void add_blocks(int block_y);
    void step_by_blocks(PaddedDisparity& disparity_px, PaddedDisparity& sigma_px);

    base::Instructions instructions_;
    LucasKanadeTerms terms_;
    Blocks blocks_;
};

}  // namespace divemesh::stereo
