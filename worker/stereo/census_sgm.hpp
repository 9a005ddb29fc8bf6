#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/base/instructions.hpp"
#include "worker/stereo/search_tiles.hpp"
#include "worker/stereo/sgm_kernels.hpp"
#include "worker/types/disparity_range.hpp"

namespace divemesh::stereo {

// Semi-global matching (Hirschmueller 2008) of 32-bit census signatures (Zabih and Woodfill 1994)
// along five paths: from the left, from the right and from the three pixels above. All five end in
// the current row, so one sweep down the image needs one row of costs per path and no cost volume.
// P2 is lower where the grey value changes. Winners pass a uniqueness check and a left-right check.
// Grey values that differ by less than a tolerance count as equal, so that a surface without
// texture costs the same at every disparity and gets that of its edges, not one drawn by noise.
class CensusSgm {
public:
    static constexpr int kMinTolerance = 1;  // rounding to grey values

    // `num_disparities` is at most 512 and is rounded up to a multiple of 32.
    explicit CensusSgm(int num_disparities,
                       base::Instructions instructions = base::best_instructions());

    // Returns the disparity of the left image of a rectified pair (CV_8UC1), CV_32F, px; 0:
    // unknown; negative: an unconfirmed winner, in whole pixels.
    cv::Mat compute(const cv::Mat& left, const cv::Mat& right);
    // The same within a range; its number is rounded up likewise. `tolerance` is in grey values.
    cv::Mat compute(const cv::Mat& left,
                    const cv::Mat& right,
                    const types::DisparityRange& range,
                    int tolerance = kMinTolerance);
    // The same, each tile within its own range. The left-right check is over all tiles, so that
    // what hides a surface need not be in its tile.
    cv::Mat compute(const cv::Mat& left,
                    const cv::Mat& right,
                    const std::vector<SearchTile>& tiles,
                    int tolerance);

private:
    static constexpr int kRowsAtOnce = 2;  // per call of a kernel

    // Costs aligned for vectors.
    struct alignas(kMaxVectorBytes) Line {
        std::uint8_t bytes[kMaxVectorBytes];
    };
    struct Costs {
        std::vector<Line> lines;
        void resize(std::size_t num_bytes);
        std::uint8_t* begin() { return lines.front().bytes; }
    };
    struct Row {
        // P2: three from above, from the left, from the right.
        std::vector<std::uint8_t> penalty[5];
        Costs cost;                          // [x][d]
        Costs sum;                           // over the paths, [x][d]
        std::vector<std::uint8_t> min_cost;  // of the sums, by x; below, its index and more
        std::vector<std::int16_t> min_at;
        std::vector<std::uint8_t> is_unique;
        std::vector<std::uint8_t> lower;
        std::vector<std::uint8_t> upper;
    };
    // Costs of one path, see VerticalPath.
    struct Slots {
        Costs costs;
        std::vector<std::uint8_t> min_cost;
    };

    // The best disparities of the image and what the checks need, by pixel.
    struct Winners {
        cv::Mat min_cost;   // CV_8U, of the sums
        cv::Mat min_at;     // CV_16S, px
        cv::Mat is_unique;  // CV_8U
        cv::Mat lower;      // CV_8U, the sums at neighbouring disparities
        cv::Mat upper;
        void create(cv::Size size);
    };

    void find_winners(const cv::Mat& left, const SearchTile& tile);
    void begin_path(std::uint8_t* costs) const;
    void prepare();
    void prepare_row(const cv::Mat& left, int y, Row& row) const;
    void aggregate(int y, int num_rows);
    VerticalPath vertical_path(int p, int y);
    void select_winners(int num_rows);
    void keep_winners(const Row& row, int y, const cv::Rect& part);
    void write_row(int y, float* disparity_px);

    int num_disparities_;  // of the current range
    int whole_num_disparities_;
    int first_disparity_ = 0;
    SgmKernels kernels_;
    int image_width_ = 0;
    cv::Rect seen_;                              // the current tile with its surroundings
    int width_ = 0;                              // of it
    int stride_ = 0;                             // of [d], whole vectors
    std::vector<std::uint8_t> left_census_[4];   // byte planes of the signatures
    std::vector<std::uint8_t> right_census_[4];  // from right to left: d increases with the address
    Row rows_[kRowsAtOnce];
    Slots above_[3];
    Winners winners_;
    std::vector<std::uint32_t> right_best_;
};

}  // namespace divemesh::stereo
