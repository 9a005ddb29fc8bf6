#include "worker/stereo/census_sgm.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "worker/stereo/sgm_kernels.hpp"

namespace divemesh::worker {
namespace {

constexpr int kRadiusX_px = 4;  // of the census window
constexpr int kRadiusY_px = 3;
constexpr int kLargestStepPenalty = 60;  // P2 on even ground
constexpr int kLeastStepPenalty = 20;    // P2 across an edge
constexpr int kUniqueness_percent = 5;
constexpr int kLeftRightTolerance_px = 1;
constexpr std::int16_t kUnknown = -1;

struct Offset {
    int x;
    int y;
};

// Every other pixel of the 9 x 7 window, as on a chess board: 31 of them, and one corner.
std::vector<Offset> census_pattern() {
    std::vector<Offset> pattern;
    for (int y = -kRadiusY_px; y <= kRadiusY_px; ++y)
        for (int x = -kRadiusX_px; x <= kRadiusX_px; ++x)
            if ((x != 0 || y != 0) && ((x + y) & 1) == 0) pattern.push_back({x, y});
    pattern.resize(kNumCensusBits - 1);
    pattern.push_back({kRadiusX_px, -kRadiusY_px});
    return pattern;
}

void census(const cv::Mat& image, CensusKernel kernel, std::vector<std::uint8_t>* planes) {
    static const std::vector<Offset> pattern = census_pattern();
    const int num = image.cols - 2 * kRadiusX_px;
    for (int p = 0; p < 4; ++p) {
        planes[p].assign(image.total(), 0);
        for (int y = kRadiusY_px; y < image.rows - kRadiusY_px; ++y) {
            const std::uint8_t* neighbours[8];
            for (int k = 0; k < 8; ++k) {
                const Offset& offset = pattern[p * 8 + k];
                neighbours[k] = image.ptr<std::uint8_t>(y + offset.y) + kRadiusX_px + offset.x;
            }
            std::uint8_t* row = planes[p].data() + static_cast<std::size_t>(y) * image.cols;
            kernel(image.ptr<std::uint8_t>(y) + kRadiusX_px, neighbours, num, row + kRadiusX_px);
        }
    }
}

// The path costs of a place where a path begins: zero, so that the first pixel has its own cost.
void begin_path(std::uint8_t* costs, int num_disparities) {
    std::memset(costs, kOutsideCost, num_disparities + 2 * kPathMargin);
    std::memset(costs + kPathMargin, 0, num_disparities);
}

float interpolate(const std::uint8_t* sum, int d) {
    const int left = sum[d - 1], center = sum[d], right = sum[d + 1];
    const int slope = std::max(left, right) - center;
    if (slope == 0) return static_cast<float>(d);
    return static_cast<float>(d) +
           0.5F * static_cast<float>(left - right) / static_cast<float>(slope);
}

}  // namespace

CensusSgm::CensusSgm(int num_disparities, Instructions instructions)
    : num_disparities_((num_disparities + 31) / 32 * 32), instructions_(instructions) {
    for (int step = 0; step < 256; ++step)
        step_penalty_[step] = static_cast<std::uint8_t>(
            std::max(kLeastStepPenalty, kLargestStepPenalty * 12 / (12 + step)));
}

cv::Mat CensusSgm::compute(const cv::Mat& left, const cv::Mat& right) {
    cv::Mat disparity(left.size(), CV_32F, cv::Scalar(0.0));
    if (left.cols <= 2 * kRadiusX_px || left.rows <= 2 * kRadiusY_px) return disparity;
    prepare(left);
    const SgmKernels kernels = sgm_kernels(instructions_);
    census(left, kernels.census, left_census_);
    census(right, kernels.census, right_census_);
    for (int y = 0; y < height_; ++y) {
        aggregate_row(left, y);
        select_winners(left.ptr<std::uint8_t>(y));
        write_row(disparity.ptr<float>(y));
        for (int p = 0; p < 3; ++p) {
            std::swap(above_[0][p], above_[1][p]);
            std::swap(above_min_[0][p], above_min_[1][p]);
        }
    }
    return disparity;
}

void CensusSgm::prepare(const cv::Mat& left) {
    width_ = left.cols;
    height_ = left.rows;
    const std::size_t stride = num_disparities_ + 2 * kPathMargin;
    cost_.resize(static_cast<std::size_t>(width_) * num_disparities_);
    sum_.resize(cost_.size());
    winner_.resize(width_);
    right_best_cost_.resize(width_);
    right_best_disparity_.resize(width_);
    for (auto& plane : right_reversed_) plane.assign(width_ + num_disparities_, 0);
    for (auto& row : above_)
        for (auto& path : row) {
            path.resize((width_ + 2) * stride);
            for (int x = 0; x < width_ + 2; ++x)
                begin_path(path.data() + x * stride, num_disparities_);
        }
    for (auto& row : above_min_)
        for (auto& path : row) path.assign(width_ + 2, 0);
}

void CensusSgm::aggregate_row(const cv::Mat& left, int y) {
    const SgmKernels kernels = sgm_kernels(instructions_);
    const std::size_t stride = num_disparities_ + 2 * kPathMargin;
    const std::size_t row = static_cast<std::size_t>(y) * width_;
    const std::uint8_t* grey = left.ptr<std::uint8_t>(y);
    const std::uint8_t* grey_above = left.ptr<std::uint8_t>(std::max(0, y - 1));
    for (int p = 0; p < 4; ++p)
        std::reverse_copy(right_census_[p].begin() + row,
                          right_census_[p].begin() + row + width_,
                          right_reversed_[p].begin());
    std::vector<std::uint8_t> from_left[2];
    for (auto& costs : from_left) {
        costs.resize(stride);
        begin_path(costs.data(), num_disparities_);
    }

    ForwardPixel pixel;
    pixel.num_disparities = num_disparities_;
    for (int x = 0; x < width_; ++x) {
        for (int p = 0; p < 4; ++p) {
            pixel.left[p] = left_census_[p][row + x];
            pixel.right[p] = right_reversed_[p].data() + (width_ - 1 - x);
        }
        pixel.num_in_image = std::min(num_disparities_, x + 1);
        pixel.cost = cost_.data() + static_cast<std::size_t>(x) * num_disparities_;
        pixel.sum = sum_.data() + static_cast<std::size_t>(x) * num_disparities_;
        const auto penalty = [&](int other) { return step_penalty_[std::abs(grey[x] - other)]; };
        for (int p = 0; p < 3; ++p) {  // from above left, above, above right
            const int from = std::clamp(x + p - 1, 0, width_ - 1);
            const auto column = static_cast<std::size_t>(x + p);
            pixel.paths[p].before = above_[0][p].data() + column * stride + kPathMargin;
            pixel.paths[p].here = above_[1][p].data() + (x + 1) * stride + kPathMargin;
            pixel.paths[p].before_min = above_min_[0][p][column];
            pixel.paths[p].step_penalty = penalty(grey_above[from]);
        }
        pixel.paths[3].before = from_left[x & 1].data() + kPathMargin;
        pixel.paths[3].here = from_left[(x + 1) & 1].data() + kPathMargin;
        pixel.paths[3].before_min = x == 0 ? std::uint8_t{0} : pixel.paths[3].here_min;
        pixel.paths[3].step_penalty = penalty(grey[std::max(0, x - 1)]);
        kernels.forward(pixel);
        for (int p = 0; p < 3; ++p) above_min_[1][p][x + 1] = pixel.paths[p].here_min;
    }
}

void CensusSgm::select_winners(const std::uint8_t* grey) {
    const SgmKernels kernels = sgm_kernels(instructions_);
    const std::size_t stride = num_disparities_ + 2 * kPathMargin;
    std::vector<std::uint8_t> from_right[2];
    for (auto& costs : from_right) {
        costs.resize(stride);
        begin_path(costs.data(), num_disparities_);
    }
    std::fill(right_best_cost_.begin(), right_best_cost_.end(), std::uint8_t{255});

    BackwardPixel pixel;
    pixel.num_disparities = num_disparities_;
    for (int x = width_ - 1; x >= 0; --x) {
        pixel.cost = cost_.data() + static_cast<std::size_t>(x) * num_disparities_;
        pixel.sum = sum_.data() + static_cast<std::size_t>(x) * num_disparities_;
        pixel.path.before = from_right[x & 1].data() + kPathMargin;
        pixel.path.here = from_right[(x + 1) & 1].data() + kPathMargin;
        pixel.path.before_min = x == width_ - 1 ? std::uint8_t{0} : pixel.path.here_min;
        pixel.path.step_penalty =
            step_penalty_[std::abs(grey[x] - grey[std::min(width_ - 1, x + 1)])];
        kernels.backward(pixel);
        const auto* found =
            static_cast<const std::uint8_t*>(std::memchr(pixel.sum, pixel.best, num_disparities_));
        const int d = static_cast<int>(found - pixel.sum);
        winner_[x] = is_unique(pixel.sum, d) && d < x ? static_cast<std::int16_t>(d) : kUnknown;
        if (d <= x && pixel.best < right_best_cost_[x - d]) {
            right_best_cost_[x - d] = pixel.best;
            right_best_disparity_[x - d] = static_cast<std::int16_t>(d);
        }
    }
}

// Nothing else than the neighbours of the winner comes near its cost. Winners at the ends of the
// range have no parabola and are most likely cut off: unknown.
bool CensusSgm::is_unique(std::uint8_t* sum, int d) const {
    if (d == 0 || d == num_disparities_ - 1) return false;
    const int best = sum[d];
    std::uint8_t around[3];
    std::memcpy(around, sum + d - 1, 3);
    std::memset(sum + d - 1, 255, 3);
    const int second = sgm_kernels(instructions_).least(sum, num_disparities_);
    std::memcpy(sum + d - 1, around, 3);
    return best < 255 && second * (100 - kUniqueness_percent) > best * 100;
}

void CensusSgm::write_row(float* disparity_px) const {
    for (int x = 0; x < width_; ++x) {
        const int d = winner_[x];
        if (d == kUnknown || std::abs(right_best_disparity_[x - d] - d) > kLeftRightTolerance_px)
            continue;
        disparity_px[x] =
            interpolate(sum_.data() + static_cast<std::size_t>(x) * num_disparities_, d);
    }
}

}  // namespace divemesh::worker
