#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::features {

// The score of each pixel measures how well it can be localised: the smaller eigenvalue of the mean
// of g g^T over the surrounding 5 x 5 pixels, g the gradient by Sobel's 3 x 3 (Shi and Tomasi,
// "Good features to track", 1994). Keeps its buffers between images.
class CornerScores {
public:
    static constexpr int kBorder_px = 3;    // score 0
    static constexpr float kNoise = 0.65F;  // about the score of noise alone

    explicit CornerScores(base::Instructions instructions = base::best_instructions())
        : instructions_(instructions) {}

    // Returns the scores of an image (CV_8UC1) as CV_32F, (grey levels / px)^2; valid until the
    // next call.
    const cv::Mat& of(const cv::Mat& image);

private:
    base::Instructions instructions_;
    cv::Mat scores_;
    std::vector<std::int32_t> products_;  // of the last five rows, followed by their column sums
};

// Returns the best pixel of each square cell inside the borders, row by row, if it scores at least
// `min_score`.
std::vector<cv::Point> best_of_cells(const cv::Mat& scores,
                                     float min_score,
                                     int border_px,
                                     int cell_px);

}  // namespace divemesh::features
