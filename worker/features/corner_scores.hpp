#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::features {

// How well each pixel of a picture can be found again, whichever way it moves: the lesser
// eigenvalue of the mean of g g^T over the 5 x 5 pixels around it, g the gradient by Sobel's 3 x 3
// (Shi and Tomasi, "Good features to track", 1994). Keeps its buffers from picture to picture.
class CornerScores {
public:
    static constexpr int kBorder_px = 3;    // score 0
    static constexpr float kNoise = 0.65F;  // about what noise alone scores

    explicit CornerScores(base::Instructions instructions = base::best_instructions())
        : instructions_(instructions) {}

    // `image` CV_8UC1. CV_32F, (grey levels / px)^2; good until the next call.
    const cv::Mat& of(const cv::Mat& image);

private:
    base::Instructions instructions_;
    cv::Mat scores_;
    std::vector<std::int32_t> products_;  // of the last five rows, then summed by column
};

// The best pixel of each square cell between the borders, row by row, where it scores at least
// `least`.
std::vector<cv::Point> best_of_cells(const cv::Mat& scores,
                                     float least,
                                     int border_px,
                                     int cell_px);

}  // namespace divemesh::features
