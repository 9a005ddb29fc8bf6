#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/base/instructions.hpp"
#include "worker/stereo/lucas_kanade_terms.hpp"
#include "worker/stereo/padded_disparity.hpp"

namespace divemesh::stereo {

// A wide window measures what its disparities are off together. By itself each is off by as much as
// a winner of the matcher is where there is little texture, and its neighbours with it.
inline constexpr float kWideSigma_px = 1.0F;

// One Lucas-Kanade step of a disparity over a window of 9 x 9 px in which every pixel keeps its own
// disparity; gain and bias between the cameras are estimated with it. Where there is too little
// texture for that, over 27 x 27 px.
class SubpixelRefinement {
public:
    explicit SubpixelRefinement(base::Instructions instructions)
        : instructions_(instructions), terms_(instructions) {}

    // CV_8UC1 pictures of more than 8 x 8 px; `disparity_px` takes the step. `sigma_px`: standard
    // deviation of the least squares, from what they leave unexplained; 0: even the wide window
    // shows hardly more than noise.
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
