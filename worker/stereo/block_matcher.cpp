#include "worker/stereo/block_matcher.hpp"

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "worker/stereo/block_kernels.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kRadius_px = 4;   // of the window
constexpr int kMaxDetail = 31;  // grey values; 81 differences of at most twice that fit in 16 bits
constexpr int kUniqueness_percent = 8;
constexpr int kLeftRightTolerance_px = 1;
constexpr std::int16_t kUnknown = -1;

// Returns the clipped difference from the mean of the neighbourhood.
cv::Mat high_pass(const cv::Mat& image) {
    cv::Mat mean;
    cv::boxFilter(image, mean, CV_8U, cv::Size(9, 9));
    cv::Mat detail(image.size(), CV_8U);
    for (int y = 0; y < image.rows; ++y) {
        const std::uint8_t* in = image.ptr<std::uint8_t>(y);
        const std::uint8_t* around = mean.ptr<std::uint8_t>(y);
        std::uint8_t* out = detail.ptr<std::uint8_t>(y);
        for (int x = 0; x < image.cols; ++x) {
            const int difference = in[x] - around[x];
            out[x] = static_cast<std::uint8_t>(std::clamp(difference, -kMaxDetail, kMaxDetail) +
                                               kMaxDetail);
        }
    }
    return detail;
}

// Reverses each row and appends `margin` bytes, so that d increases with the address.
cv::Mat reverse_rows(const cv::Mat& image, int margin) {
    cv::Mat reversed(image.rows, image.cols + margin, CV_8U, cv::Scalar(0));
    cv::flip(image, reversed.colRange(0, image.cols), 1);
    return reversed;
}

}  // namespace

BlockMatcher::BlockMatcher(int num_disparities, base::Instructions instructions)
    : num_disparities_((num_disparities + 31) / 32 * 32), instructions_(instructions) {}

cv::Mat BlockMatcher::compute(const cv::Mat& left, const cv::Mat& right) {
    cv::Mat disparity(left.size(), CV_32F, cv::Scalar(0.0));
    width_ = left.cols;
    column_cost_.assign(static_cast<std::size_t>(width_) * num_disparities_, 0);
    winner_.resize(width_);
    winner_subpixel_.resize(width_);
    right_best_cost_.resize(width_);
    right_best_disparity_.resize(width_);
    const cv::Mat left_detail = high_pass(left);
    const cv::Mat right_detail = reverse_rows(high_pass(right), num_disparities_);

    const BlockKernels kernels = block_kernels(instructions_);
    const auto accumulate_row = [&](int y, int sign) {
        const std::uint8_t* l = left_detail.ptr<std::uint8_t>(y);
        const std::uint8_t* r = right_detail.ptr<std::uint8_t>(y);
        for (int x = 0; x < width_; ++x)
            kernels.accumulate(&column_cost_[static_cast<std::size_t>(x) * num_disparities_],
                               l[x],
                               r + (width_ - 1 - x),
                               num_disparities_,
                               sign);
    };
    for (int y = 0; y < left.rows; ++y) {
        accumulate_row(y, 1);
        if (y > 2 * kRadius_px) accumulate_row(y - 2 * kRadius_px - 1, -1);
        if (y >= 2 * kRadius_px) select_row(disparity.ptr<float>(y - kRadius_px));
    }
    return disparity;
}

void BlockMatcher::select_row(float* disparity_px) {
    const BlockKernels kernels = block_kernels(instructions_);
    const auto column = [&](int x) {
        return column_cost_.data() + static_cast<std::size_t>(x) * num_disparities_;
    };
    std::fill(winner_.begin(), winner_.end(), kUnknown);
    std::fill(right_best_cost_.begin(), right_best_cost_.end(), std::uint16_t{0xffff});
    std::vector<std::uint16_t> window(num_disparities_, 0);
    const std::vector<std::uint16_t> nothing(num_disparities_, 0);
    for (int x = 0; x < width_; ++x) {
        const std::uint16_t* leaving =
            x > 2 * kRadius_px ? column(x - 2 * kRadius_px - 1) : nothing.data();
        kernels.slide(window.data(), column(x), leaving, num_disparities_);
        if (x >= 2 * kRadius_px) select_pixel(x - kRadius_px, window.data());
    }
    for (int x = 0; x < width_; ++x) {
        const int d = winner_[x];
        if (d != kUnknown && std::abs(right_best_disparity_[x - d] - d) <= kLeftRightTolerance_px)
            disparity_px[x] = winner_subpixel_[x];
    }
}

void BlockMatcher::select_pixel(int x, std::uint16_t* window_cost) {
    const BlockKernels kernels = block_kernels(instructions_);
    const int num_in_image = std::min(num_disparities_, x + 1 - kRadius_px);
    if (num_in_image < 3) return;
    std::uint16_t* cost = window_cost;
    std::vector<std::uint16_t> cut;
    if (num_in_image < num_disparities_) {
        cut.assign(cost, cost + num_disparities_);
        std::fill(cut.begin() + num_in_image, cut.end(), std::uint16_t{0xffff});
        cost = cut.data();
    }
    const std::uint16_t best = kernels.min_cost(cost, num_disparities_);
    const int d = kernels.find(cost, best, num_disparities_);
    if (best < right_best_cost_[x - d]) {
        right_best_cost_[x - d] = best;
        right_best_disparity_[x - d] = static_cast<std::int16_t>(d);
    }
    if (d == 0 || d >= num_in_image - 1) return;

    const std::uint16_t around[3] = {cost[d - 1], cost[d], cost[d + 1]};
    std::fill(cost + d - 1, cost + d + 2, std::uint16_t{0xffff});
    const int second = kernels.min_cost(cost, num_disparities_);
    std::copy(around, around + 3, cost + d - 1);
    if (second * (100 - kUniqueness_percent) <= best * 100) return;

    // Two lines of equal slope through the three costs, the shape of a sum of absolute differences.
    const int slope = std::max(around[0], around[2]) - around[1];
    winner_[x] = static_cast<std::int16_t>(d);
    winner_subpixel_[x] =
        static_cast<float>(d) +
        (slope > 0 ? 0.5F * static_cast<float>(around[0] - around[2]) / static_cast<float>(slope)
                   : 0.0F);
}

}  // namespace divemesh::stereo
