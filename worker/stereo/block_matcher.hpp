#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// The paper's matcher: the min over all disparities of the sum of absolute differences in a square
// window, with sub-pixel interpolation, uniqueness and left-right check. Both images are
// high-passed first, so that a different gain or backscatter in one camera does not matter. Window
// sums are running sums, so the cost does not depend on the window's size.
class BlockMatcher {
public:
    explicit BlockMatcher(int num_disparities,
                          base::Instructions instructions = base::best_instructions());

    // Returns the disparity of the left image of a rectified pair (CV_8UC1), CV_32F, px; 0:
    // unknown.
    cv::Mat compute(const cv::Mat& left, const cv::Mat& right);

private:
    void select_row(float* disparity_px);
    void select_pixel(int x, std::uint16_t* window_cost);

    int num_disparities_;  // multiple of 32
    base::Instructions instructions_;
    int width_ = 0;
    std::vector<std::uint16_t> column_cost_;  // over the window's height, [x][d]
    std::vector<std::int16_t> winner_;
    std::vector<float> winner_subpixel_;
    std::vector<std::uint16_t> right_best_cost_;
    std::vector<std::int16_t> right_best_disparity_;
};

}  // namespace divemesh::stereo
