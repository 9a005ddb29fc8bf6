#include "worker/features/epipolar_search.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace divemesh::features {
namespace {

constexpr int kSide_px = 2 * EpipolarSearch::kRadius_px + 1;
constexpr int kNumPixels = kSide_px * kSide_px;
constexpr int kOnePeak_px = 2;  // disparities this close belong to the same peak

// A strip of both images, with `num` positions in the right one.
struct Strip {
    const std::uint8_t* left;   // upper left corner of the square
    const std::uint8_t* right;  // the same of the leftmost position
    std::ptrdiff_t left_step;
    std::ptrdiff_t right_step;
    int num;
    std::uint16_t* columns;
    std::int16_t* offsets;
    std::uint16_t* costs;
};

DIVEMESH_INLINE_BODY void compare(const Strip& strip) {
    const int num = strip.num;
    std::uint16_t* __restrict columns = strip.columns;
    std::int16_t* __restrict offsets = strip.offsets;
    std::uint16_t* __restrict costs = strip.costs;
    int left_sum = 0;
    for (int v = 0; v < kSide_px; ++v) {
        const std::uint8_t* __restrict right = strip.right + v * strip.right_step;
        for (int i = 0; i < num + kSide_px - 1; ++i)
            columns[i] = static_cast<std::uint16_t>((v == 0 ? 0 : columns[i]) + right[i]);
        for (int u = 0; u < kSide_px; ++u) left_sum += strip.left[v * strip.left_step + u];
    }
    for (int i = 0; i < num; ++i) {
        int right_sum = 0;
        for (int u = 0; u < kSide_px; ++u) right_sum += columns[i + u];
        offsets[i] = static_cast<std::int16_t>((left_sum - right_sum) / kNumPixels);
        costs[i] = 0;
    }
    for (int v = 0; v < kSide_px; ++v) {
        for (int u = 0; u < kSide_px; ++u) {
            const std::int16_t left = strip.left[v * strip.left_step + u];
            const std::uint8_t* __restrict right = strip.right + v * strip.right_step + u;
            for (int i = 0; i < num; ++i) {
                const auto difference = static_cast<std::int16_t>(left - right[i] - offsets[i]);
                costs[i] = static_cast<std::uint16_t>(costs[i] + std::abs(difference));
            }
        }
    }
}

}  // namespace

int EpipolarSearch::find(
    const cv::Mat& left, const cv::Mat& right, int u, int v, int num_disparities_px) {
    if (v < kRadius_px || v >= left.rows - kRadius_px || u < kRadius_px ||
        u >= left.cols - kRadius_px)
        return 0;
    const int farthest = std::min(num_disparities_px, u - kRadius_px);
    if (farthest < 1) return 0;
    const int num = farthest + 1;
    columns_.resize(static_cast<std::size_t>(num) + kSide_px);
    offsets_.resize(static_cast<std::size_t>(num));
    costs_.resize(static_cast<std::size_t>(num));
    const Strip strip{left.ptr<std::uint8_t>(v - kRadius_px) + u - kRadius_px,
                      right.ptr<std::uint8_t>(v - kRadius_px) + u - farthest - kRadius_px,
                      static_cast<std::ptrdiff_t>(left.step[0]),
                      static_cast<std::ptrdiff_t>(right.step[0]),
                      num,
                      columns_.data(),
                      offsets_.data(),
                      costs_.data()};
    base::compiled_for<compare>(instructions_)(strip);

    const int best =
        static_cast<int>(std::min_element(costs_.rbegin(), costs_.rend()) - costs_.rbegin());
    int second = std::numeric_limits<int>::max();
    for (int d = 0; d < num; ++d)
        if (std::abs(d - best) > kOnePeak_px)
            second = std::min<int>(second, costs_[static_cast<std::size_t>(farthest - d)]);
    const bool unique = 10 * std::int64_t{costs_[static_cast<std::size_t>(farthest - best)]} <
                        9 * std::int64_t{second};
    return unique ? best : 0;
}

}  // namespace divemesh::features
