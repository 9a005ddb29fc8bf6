#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::features {

// The search for a square of the left image along its row in the right image.
class EpipolarSearch {
public:
    static constexpr int kRadius_px = 5;

    explicit EpipolarSearch(base::Instructions instructions = base::best_instructions())
        : instructions_(instructions) {}

    // Returns the disparity of the best square around (u, v) - (disparity, 0), in whole pixels up
    // to `num_disparities_px`. The cost is the sum of absolute differences without the mean
    // brightness, as the exposures may differ. 0 if no square fits or another position is nearly as
    // good.
    int find(const cv::Mat& left, const cv::Mat& right, int u, int v, int num_disparities_px);

private:
    base::Instructions instructions_;
    std::vector<std::uint16_t> columns_;  // column sums of the right image
    std::vector<std::int16_t> offsets_;   // left minus right brightness
    std::vector<std::uint16_t> costs_;    // per disparity, the largest first
};

}  // namespace divemesh::features
