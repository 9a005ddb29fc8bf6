#pragma once

#include <cstddef>
#include <vector>

#include "worker/compare/change_map.hpp"

namespace divemesh::compare {

// How the error of a mean change decreases with the area, measured on stable ground. Neighbouring
// cells share errors, so it decreases more slowly than with the root of their number (Rolstad, Haug
// and Denby 2009; standardised by each cell's sigma as Hugonnet et al. 2022).
class ChangeNoise {
public:
    struct Step {
        double side_m = 0.0;  // of square blocks
        double sigma = 0.0;   // of the mean over a block, in units of a cell's sigma
        std::size_t num_blocks = 0;
    };

    explicit ChangeNoise(std::vector<Step> steps) : steps_(std::move(steps)) {}

    // Returns sigma of the mean over an area, in units of a cell's sigma. An area larger than the
    // largest block has the error of that block.
    double sigma_of_mean(double area_m2) const;
    const std::vector<Step>& steps() const { return steps_; }

private:
    std::vector<Step> steps_;  // ascending sides; empty: cells share their whole error
};

// Measures the noise over the cells that both dives saw and that `counts` (CV_8U) includes: in
// blocks of 1, 2, 4 ... cells, as long as 12 of them are three quarters full. A block's sigma is
// the larger of those that hold for 68 % and for 95 % of them.
ChangeNoise measure_noise(const ChangeMap& map, const cv::Mat& counts);

}  // namespace divemesh::compare
