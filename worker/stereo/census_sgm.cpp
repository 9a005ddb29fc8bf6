#include "worker/stereo/census_sgm.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <opencv2/core.hpp>

#include "worker/stereo/sgm_kernels.hpp"

namespace divemesh::worker {
namespace {

constexpr int kRadiusX_px = 4;  // of the census window
constexpr int kRadiusY_px = 3;
constexpr int kLeftRightTolerance_px = 1;

struct Offset {
    int x;
    int y;
};

// Every other pixel of the 9 x 7 window, as on a chess board: 30 of them, and two corners.
std::vector<Offset> census_pattern() {
    std::vector<Offset> pattern;
    for (int y = -kRadiusY_px; y <= kRadiusY_px; ++y)
        for (int x = -kRadiusX_px; x <= kRadiusX_px; ++x)
            if ((x != 0 || y != 0) && ((x + y) & 1) == 0) pattern.push_back({x, y});
    pattern.push_back({kRadiusX_px, -kRadiusY_px});
    pattern.push_back({-kRadiusX_px, kRadiusY_px});
    return pattern;
}

// Beyond the border the picture goes on as its own mirror image.
void census(const cv::Mat& image, CensusKernel kernel, std::vector<std::uint8_t>* planes) {
    static const std::vector<Offset> pattern = census_pattern();
    cv::Mat wide;
    cv::copyMakeBorder(
        image, wide, kRadiusY_px, kRadiusY_px, kRadiusX_px, kRadiusX_px, cv::BORDER_REFLECT_101);
    const auto at = [&](int y, Offset offset) {
        return wide.ptr<std::uint8_t>(y + kRadiusY_px + offset.y) + kRadiusX_px + offset.x;
    };
    for (int p = 0; p < 4; ++p) {
        planes[p].resize(image.total());
        for (int y = 0; y < image.rows; ++y) {
            const std::uint8_t* neighbours[8];
            for (int k = 0; k < 8; ++k) neighbours[k] = at(y, pattern[p * 8 + k]);
            std::uint8_t* row = planes[p].data() + static_cast<std::size_t>(y) * image.cols;
            kernel(at(y, {0, 0}), neighbours, image.cols, row);
        }
    }
}

// The costs of one pixel before a path begins: zero, so that the first pixel has its own cost.
void begin_path(std::uint8_t* costs, int num_disparities) {
    std::memset(costs, 0, static_cast<std::size_t>(num_disparities));
}

// Costs of `num` pixels, each at the start of a path, between margins.
std::vector<std::uint8_t> path_starts(int num, int num_disparities) {
    const std::size_t stride = static_cast<std::size_t>(num_disparities) + kPathMargin;
    std::vector<std::uint8_t> costs(num * stride + kPathMargin + 2 * kWidestVector, kOutsideCost);
    for (int i = 0; i < num; ++i)
        begin_path(costs.data() + kPathMargin + i * stride, num_disparities);
    return costs;
}

// Between whole disparities by the two lines that a cost of absolute differences has.
float interpolate(const std::uint8_t* around, int d) {
    const int left = around[0], center = around[1], right = around[2];
    const int slope = std::max(left, right) - center;
    if (slope == 0) return static_cast<float>(d);
    return static_cast<float>(d) +
           0.5F * static_cast<float>(left - right) / static_cast<float>(slope);
}

}  // namespace

CensusSgm::CensusSgm(int num_disparities, Instructions instructions)
    : num_disparities_(num_disparities),
      whole_num_disparities_(num_disparities),
      instructions_(instructions) {}

cv::Mat CensusSgm::compute(const cv::Mat& left, const cv::Mat& right) {
    return compute(left, right, {0, whole_num_disparities_});
}

cv::Mat CensusSgm::compute(const cv::Mat& left, const cv::Mat& right, const DisparityRange& range) {
    first_disparity_ = range.first_px;
    num_disparities_ = (range.num_px + 31) / 32 * 32;
    cv::Mat disparity(left.size(), CV_32F, cv::Scalar(0.0));
    if (left.cols <= kRadiusX_px || left.rows <= kRadiusY_px) return disparity;
    prepare(left);
    const CensusKernel kernel = sgm_kernels(instructions_, num_disparities_).census;
    census(left, kernel, left_census_);
    census(right, kernel, right_census_);
    for (int y = 0; y < left.rows; y += kRowsAtOnce) {
        const int num_rows = std::min(kRowsAtOnce, left.rows - y);
        for (int i = 0; i < num_rows; ++i) prepare_row(left, y + i, rows_[i]);
        aggregate(y, num_rows);
        select_winners(num_rows);
        for (int i = 0; i < num_rows; ++i) write_row(rows_[i], disparity.ptr<float>(y + i));
    }
    return disparity;
}

void CensusSgm::prepare(const cv::Mat& left) {
    width_ = left.cols;
    const auto width = static_cast<std::size_t>(width_);
    for (Row& row : rows_) {
        row.cost.resize(width * num_disparities_ + kWidestVector);
        row.sum.resize(row.cost.size());
        row.least.resize(width);
        row.least_at.resize(width);
        row.is_unique.resize(width);
        row.around.resize(3 * width);
        for (auto& penalty : row.penalty) penalty.resize(width);
        for (auto& plane : row.right_reversed)
            plane.assign(width + first_disparity_ + num_disparities_ + kWidestVector, 0);
    }
    right_best_cost_.resize(width);
    right_best_disparity_.resize(width);
    for (Slots& path : above_) {
        path.costs = path_starts(width_ + 1, num_disparities_);
        path.least.assign(width + 1, 0);
    }
}

void CensusSgm::prepare_row(const cv::Mat& left, int y, Row& row) const {
    const std::uint8_t* grey = left.ptr<std::uint8_t>(y);
    const std::uint8_t* above = left.ptr<std::uint8_t>(std::max(0, y - 1));
    const PenaltyKernel penalties = sgm_kernels(instructions_, num_disparities_).penalties;
    // Where a path begins there is nothing to step from: any penalty will do.
    penalties(grey + 1, above, width_ - 1, row.penalty[0].data() + 1);
    penalties(grey, above, width_, row.penalty[1].data());
    penalties(grey, above + 1, width_ - 1, row.penalty[2].data());
    penalties(grey + 1, grey, width_ - 1, row.penalty[3].data() + 1);
    std::copy(row.penalty[3].begin() + 1, row.penalty[3].end(), row.penalty[4].begin());
    for (int p = 0; p < 4; ++p) {
        const auto right = right_census_[p].begin() + static_cast<std::ptrdiff_t>(y) * width_;
        std::reverse_copy(right, right + width_, row.right_reversed[p].begin());
    }
    row.from_left = path_starts(2, num_disparities_);
    row.from_right = row.from_left;
}

void CensusSgm::aggregate(int y, int num_rows) {
    ForwardRow forward[kRowsAtOnce];
    for (int i = 0; i < num_rows; ++i) {
        Row& row = rows_[i];
        forward[i].width = width_;
        forward[i].first_disparity = first_disparity_;
        forward[i].num_disparities = num_disparities_;
        for (int p = 0; p < 4; ++p) {
            forward[i].left[p] =
                left_census_[p].data() + static_cast<std::ptrdiff_t>(y + i) * width_;
            forward[i].right_reversed[p] = row.right_reversed[p].data() + first_disparity_;
            forward[i].penalty[p] = row.penalty[p].data();
        }
        for (int p = 0; p < 3; ++p) forward[i].above[p] = vertical_path(p, y + i);
        forward[i].from_left = row.from_left.data();
        forward[i].cost = row.cost.data();
        forward[i].sum = row.sum.data();
    }
    sgm_kernels(instructions_, num_disparities_).forward(forward, num_rows);
}

VerticalPath CensusSgm::vertical_path(int p, int y) {
    const int num_slots = width_ + 1;
    const int sideways = p - 1;  // from above left, above, above right
    VerticalPath path;
    path.costs = above_[p].costs.data() + kPathMargin;
    path.least = above_[p].least.data();
    path.first_slot = (sideways * y % num_slots + num_slots) % num_slots;
    if (sideways != 0) {  // it begins anew where it enters the picture
        const int slot =
            sideways < 0 ? path.first_slot : (path.first_slot + width_ - 1) % num_slots;
        begin_path(
            path.costs + static_cast<std::ptrdiff_t>(slot) * (num_disparities_ + kPathMargin),
            num_disparities_);
        path.least[slot] = 0;
    }
    return path;
}

void CensusSgm::select_winners(int num_rows) {
    BackwardRow backward[kRowsAtOnce];
    for (int i = 0; i < num_rows; ++i) {
        Row& row = rows_[i];
        backward[i].width = width_;
        backward[i].num_disparities = num_disparities_;
        backward[i].penalty = row.penalty[4].data();
        backward[i].cost = row.cost.data();
        backward[i].sum = row.sum.data();
        backward[i].from_right = row.from_right.data();
        backward[i].least = row.least.data();
        backward[i].least_at = row.least_at.data();
        backward[i].is_unique = row.is_unique.data();
        backward[i].around = row.around.data();
    }
    sgm_kernels(instructions_, num_disparities_).backward(backward, num_rows);
}

// Left-right check: of the pixels that end at one pixel of the right picture the cheapest is right.
void CensusSgm::write_row(const Row& row, float* disparity_px) {
    std::fill(right_best_cost_.begin(), right_best_cost_.end(), std::uint8_t{255});
    for (int x = width_ - 1; x >= 0; --x) {
        const int d = first_disparity_ + row.least_at[x];
        if (d > x || row.least[x] >= right_best_cost_[x - d]) continue;
        right_best_cost_[x - d] = row.least[x];
        right_best_disparity_[x - d] = static_cast<std::int16_t>(d);
    }
    for (int x = 0; x < width_; ++x) {
        const int d = first_disparity_ + row.least_at[x];
        if (d >= x) continue;
        const bool confirmed = row.is_unique[x] != 0 &&
                               std::abs(right_best_disparity_[x - d] - d) <= kLeftRightTolerance_px;
        const std::uint8_t* around = row.around.data() + 3 * static_cast<std::size_t>(x);
        disparity_px[x] = confirmed ? interpolate(around, d) : -static_cast<float>(d);
    }
}

}  // namespace divemesh::worker
