#pragma once

#include <cstddef>
#include <vector>

#include "worker/compare/change_map.hpp"

namespace divemesh::compare {

// How the error of a mean change falls with the area it is taken over, measured on stable ground:
// neighbouring cells err together, so that it falls slower than with the root of their number
// (Rolstad, Haug and Denby 2009; standardised by each cell's sigma as Hugonnet et al. 2022).
class ChangeNoise {
public:
    struct Step {
        double side_m = 0.0;  // of square blocks
        double sigma = 0.0;   // of the mean over a block, in units of a cell's own sigma
        std::size_t num_blocks = 0;
    };

    explicit ChangeNoise(std::vector<Step> steps) : steps_(std::move(steps)) {}

    // Of the mean over an area, in units of a cell's sigma. Larger areas than could be measured
    // have the error of the largest that could.
    double sigma_of_mean(double area_m2) const;
    const std::vector<Step>& steps() const { return steps_; }

private:
    std::vector<Step> steps_;  // rising sides; empty: as if cells erred by their sigma together
};

// Over the cells that both saw and `counts` (CV_8U) leaves in: blocks of 1, 2, 4 ... cells, as long
// as there are 12 that are three quarters full. A block's sigma is the larger of what holds for 68
// % and for 95 % of them.
ChangeNoise measure_noise(const ChangeMap& map, const cv::Mat& counts);

}  // namespace divemesh::compare
