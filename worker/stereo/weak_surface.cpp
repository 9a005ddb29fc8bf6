#include "worker/stereo/weak_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace divemesh::stereo {
namespace {

constexpr int kBlock_px = 4;
constexpr int kMinMeasured = 6;  // pixels of a block that counts as measured
// Directions in opposite pairs: along x, along y and both diagonals.
constexpr int kDirections[8][2] = {
    {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {1, -1}, {-1, 1}};
constexpr int kNumAxes = 4;
constexpr int kMinAxes = 2;
constexpr float kReach = 0.1F;     // of the image's width
constexpr float kMaxSlope = 0.3F;  // of a surface between two supports, px per px
constexpr float kSupportNoise_px = 1.0F;
constexpr float kTolerance_px = 2.5F;  // of the winner, beyond the supports
constexpr float kMinGapSigma_px = 1.2F;
constexpr float kSigmaPerDistance = 0.04F;  // bulges between supports
constexpr float kSigmaPerStep = 0.15F;      // of the disparity between supports
constexpr float kMaxSigma_px = 3.0F;
// A gap as small as this is filled whatever its winners.
constexpr float kClose_px = 1.5F * kBlock_px;
constexpr int kMinClose = 3;
constexpr float kMaxUneven_px = 0.7F;
constexpr float kSmallGapSigma_px = 0.5F;

}  // namespace

void WeakSurface::add(const cv::Mat& winners_px, cv::Mat& disparity_px, cv::Mat& sigma_px) {
    columns_ = disparity_px.cols / kBlock_px;
    rows_ = disparity_px.rows / kBlock_px;
    if (columns_ == 0 || rows_ == 0) return;
    reach_px_ = kReach * static_cast<float>(disparity_px.cols);
    measure_blocks(disparity_px);
    for (int i = 0; i < 8; ++i) look_along(i, kDirections[i][0], kDirections[i][1]);
    for (int y = 0; y < rows_; ++y)
        for (int x = 0; x < columns_; ++x) {
            const std::size_t block = static_cast<std::size_t>(y) * columns_ + x;
            if (has_gaps_[block] == 0) continue;
            const Plane plane = plane_of(block);
            if (plane.disparity_px > 0.0F)
                add_block(winners_px, x, y, plane, disparity_px, sigma_px);
        }
}

void WeakSurface::measure_blocks(const cv::Mat& disparity_px) {
    const std::size_t num = static_cast<std::size_t>(columns_) * rows_;
    measured_px_.assign(num, 0.0F);
    has_gaps_.assign(num, 0);
    for (int y = 0; y < rows_; ++y) {
        const float* rows[kBlock_px];
        for (int i = 0; i < kBlock_px; ++i) rows[i] = disparity_px.ptr<float>(y * kBlock_px + i);
        for (int x = 0; x < columns_; ++x) {
            float sum = 0.0F;
            int count = 0;
            for (const float* row : rows)
                for (int i = x * kBlock_px; i < (x + 1) * kBlock_px; ++i) {
                    sum += row[i] > 0.0F ? row[i] : 0.0F;
                    count += row[i] > 0.0F ? 1 : 0;
                }
            const std::size_t block = static_cast<std::size_t>(y) * columns_ + x;
            if (count >= kMinMeasured) measured_px_[block] = sum / static_cast<float>(count);
            has_gaps_[block] = count < kBlock_px * kBlock_px ? 1 : 0;
        }
    }
}

// Finds for each block the nearest measured one in the direction (dx, dy), from its neighbour
// there.
void WeakSurface::look_along(int direction, int dx, int dy) {
    std::vector<Support>& supports = supports_[direction];
    supports.assign(measured_px_.size(), Support{});
    const float step_px =
        static_cast<float>(kBlock_px) * (dx != 0 && dy != 0 ? std::sqrt(2.0F) : 1.0F);
    for (int i = 0; i < rows_; ++i) {
        const int y = dy > 0 ? rows_ - 1 - i : i;
        if (y + dy < 0 || y + dy >= rows_) continue;
        for (int j = 0; j < columns_; ++j) {
            const int x = dx > 0 ? columns_ - 1 - j : j;
            if (x + dx < 0 || x + dx >= columns_) continue;
            const std::size_t next = static_cast<std::size_t>(y + dy) * columns_ + x + dx;
            Support& here = supports[static_cast<std::size_t>(y) * columns_ + x];
            if (measured_px_[next] > 0.0F)
                here = {measured_px_[next], step_px};
            else if (supports[next].distance_px + step_px <= reach_px_)
                here = {supports[next].disparity_px, supports[next].distance_px + step_px};
        }
    }
}

WeakSurface::Plane WeakSurface::plane_of(std::size_t block) const {
    Plane plane;
    float sum_weights = 0.0F;
    float sum = 0.0F;
    float sum_squares = 0.0F;
    float nearest_px = reach_px_;
    float max_step_px = 0.0F;
    int num_axes = 0;
    int num_close = 0;
    for (int axis = 0; axis < kNumAxes; ++axis) {
        const Support& a = supports_[static_cast<std::size_t>(2 * axis)][block];
        const Support& b = supports_[static_cast<std::size_t>(2 * axis + 1)][block];
        if (a.disparity_px <= 0.0F || b.disparity_px <= 0.0F) continue;
        const float length = a.distance_px + b.distance_px;
        const float step = b.disparity_px - a.disparity_px;
        if (std::abs(step) > kSupportNoise_px + kMaxSlope * length) continue;
        const float between = a.disparity_px + step * a.distance_px / length;
        if (axis == 0) plane.slope_x = step / length;
        if (axis == 1) plane.slope_y = step / length;
        const float low = std::min(a.disparity_px, b.disparity_px);
        const float high = std::max(a.disparity_px, b.disparity_px);
        plane.min_px = num_axes == 0 ? low : std::min(plane.min_px, low);
        plane.max_px = num_axes == 0 ? high : std::max(plane.max_px, high);
        const float weight = 1.0F / length;
        sum_weights += weight;
        sum += weight * between;
        sum_squares += weight * between * between;
        nearest_px = std::min(nearest_px, std::min(a.distance_px, b.distance_px));
        max_step_px = std::max(max_step_px, std::abs(step));
        ++num_axes;
        num_close += std::max(a.distance_px, b.distance_px) <= kClose_px ? 1 : 0;
    }
    if (num_axes < kMinAxes) return plane;
    plane.disparity_px = sum / sum_weights;
    const float variance =
        std::max(0.0F, sum_squares / sum_weights - plane.disparity_px * plane.disparity_px);
    const float bulge_px = kSigmaPerDistance * nearest_px;
    const float bend_px = kSigmaPerStep * max_step_px;
    plane.is_around = num_close >= kMinClose && variance <= kMaxUneven_px * kMaxUneven_px;
    const float least_px = plane.is_around ? kSmallGapSigma_px : kMinGapSigma_px;
    plane.sigma_px =
        std::sqrt(least_px * least_px + variance + bulge_px * bulge_px + bend_px * bend_px);
    if (plane.sigma_px > kMaxSigma_px) plane.disparity_px = 0.0F;
    return plane;
}

void WeakSurface::add_block(const cv::Mat& winners_px,
                            int block_x,
                            int block_y,
                            const Plane& plane,
                            cv::Mat& disparity_px,
                            cv::Mat& sigma_px) const {
    constexpr float kCentre = 0.5F * (kBlock_px - 1);
    for (int i = 0; i < kBlock_px; ++i) {
        const int y = block_y * kBlock_px + i;
        const float* winners = winners_px.ptr<float>(y);
        float* disparities = disparity_px.ptr<float>(y);
        float* sigmas = sigma_px.ptr<float>(y);
        for (int j = 0; j < kBlock_px; ++j) {
            const int x = block_x * kBlock_px + j;
            const float winner = std::abs(winners[x]);
            if (disparities[x] > 0.0F) continue;
            const float expected = plane.disparity_px +
                                   plane.slope_x * (static_cast<float>(j) - kCentre) +
                                   plane.slope_y * (static_cast<float>(i) - kCentre);
            const bool agrees = winner >= std::min(plane.min_px, expected) - kTolerance_px &&
                                winner <= std::max(plane.max_px, expected) + kTolerance_px;
            if (expected <= 0.0F || !(agrees || plane.is_around)) continue;
            disparities[x] = expected;
            sigmas[x] = plane.sigma_px;
        }
    }
}

}  // namespace divemesh::stereo
