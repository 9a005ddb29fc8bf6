#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/stereo/instructions.hpp"

namespace divemesh::worker {

// Semi-global matching (Hirschmueller 2008) of 32-bit census signatures (Zabih and Woodfill 1994)
// along five paths: from the left, from the right and from the three pixels above. All five end in
// the row at hand, so one sweep down the image needs two rows of cost and no cost volume. P2 falls
// where the grey value steps. Winners pass a uniqueness and a left-right check.
class CensusSgm {
public:
    explicit CensusSgm(int num_disparities, Instructions instructions = best_instructions());

    // CV_8UC1 rectified pair -> CV_32F disparity of the left image, px; 0: unknown.
    cv::Mat compute(const cv::Mat& left, const cv::Mat& right);

private:
    void prepare(const cv::Mat& left);
    void aggregate_row(const cv::Mat& left, int y);
    void select_winners(const std::uint8_t* grey);
    bool is_unique(std::uint8_t* sum, int d) const;
    void write_row(float* disparity_px) const;

    int num_disparities_;  // multiple of 32
    Instructions instructions_;
    int width_ = 0;
    int height_ = 0;
    std::vector<std::uint8_t> left_census_[4];  // byte planes of the signatures
    std::vector<std::uint8_t> right_census_[4];
    std::vector<std::uint8_t> right_reversed_[4];  // of one row, so that d runs with the address
    std::vector<std::uint8_t> cost_;               // of one row, [x][d]
    std::vector<std::uint8_t> sum_;                // over the paths, [x][d]
    std::vector<std::uint8_t> above_[2][3];        // path costs of a row, [x + 1][d]: last, this
    std::vector<std::uint8_t> above_min_[2][3];
    std::vector<std::uint8_t> right_best_cost_;
    std::vector<std::int16_t> right_best_disparity_;
    std::vector<std::int16_t> winner_;
    std::uint8_t step_penalty_[256] = {};  // P2 by grey value step
};

}  // namespace divemesh::worker
