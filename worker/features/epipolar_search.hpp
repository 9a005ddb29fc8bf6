#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::features {

// Looks for a square of the left picture along its row of the right one.
class EpipolarSearch {
public:
    static constexpr int kRadius_px = 5;

    explicit EpipolarSearch(base::Instructions instructions = base::best_instructions())
        : instructions_(instructions) {}

    // The disparity of the best square around (u, v) - (disparity, 0), whole pixels up to
    // `num_disparities_px`, by the sum of absolute differences after the mean brightness is taken
    // away: the cameras may be exposed differently. 0 when none is there or another place is
    // nearly as good.
    int find(const cv::Mat& left, const cv::Mat& right, int u, int v, int num_disparities_px);

private:
    base::Instructions instructions_;
    std::vector<std::uint16_t> columns_;  // sums of the right picture's
    std::vector<std::int16_t> offsets_;   // left brighter than right
    std::vector<std::uint16_t> costs_;    // of the disparities, the largest first
};

}  // namespace divemesh::features
