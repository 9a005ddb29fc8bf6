#include "worker/fusion/mark_bridges.hpp"

#include <algorithm>
#include <cstddef>

#include "worker/base/lanes.hpp"

namespace divemesh::fusion {
namespace {

constexpr int kNear_px = 4;  // from the middle of a bridge to its ends
constexpr int kFar_px = 10;  // and to where the surfaces beside it are compared
constexpr float kSteeper = 1.5F;
// Tangent of the angle of incidence: the slope of a disparity d is d tan / f.
constexpr float kMinTangent = 4.0F;
constexpr float kMinSigmas = 5.0F;

// Returns where the disparities at eight pixels are on a bridge along one axis; `step` leads to the
// next pixel on it.
DIVEMESH_INLINE_BODY base::Masks on_bridge(const float* at,
                                           std::ptrdiff_t step,
                                           base::Floats min_change) {
    constexpr float kSpan_px = 2.0F * kNear_px;
    constexpr float kSide_px = kFar_px - kNear_px;
    const base::Floats before = base::load(at - kNear_px * step);
    const base::Floats behind = base::load(at + kNear_px * step);
    const base::Floats far_before = base::load(at - kFar_px * step);
    const base::Floats far_behind = base::load(at + kFar_px * step);
    const base::Floats change = base::abs(behind - before);
    const base::Floats beside =
        base::max(base::abs(before - far_before), base::abs(far_behind - behind));
    return (before > 0.0F) & (behind > 0.0F) & (far_before > 0.0F) & (far_behind > 0.0F) &
           (change > min_change) & (change * kSide_px > beside * (kSteeper * kSpan_px));
}

// The maps at one row.
struct BridgeRow {
    const float* disparity;  // the next row is `stride` floats further
    std::ptrdiff_t stride;
    const float* sigma;
    float* rim;
    int width;
};

DIVEMESH_INLINE_BODY void mark_row(const BridgeRow& row, float focal_px) {
    constexpr float kSpan_px = 2.0F * kNear_px;
    for (int start = kFar_px; start < row.width - kFar_px; start += base::kLanes) {
        // The last eight pixels overlap the previous ones.
        const int u = std::min(start, row.width - kFar_px - base::kLanes);
        const float* at = row.disparity + u;
        const base::Floats min_change =
            base::max(kMinSigmas * base::load(row.sigma + u),
                      kSpan_px * kMinTangent / focal_px * base::load(at));
        const base::Masks bridge =
            on_bridge(at, 1, min_change) | on_bridge(at, row.stride, min_change);
        base::store(row.rim + u, base::select(~bridge, base::load(row.rim + u)));
    }
}

}  // namespace

void mark_bridges(const cv::Mat& disparity_px,
                  const cv::Mat& sigma_px,
                  double focal_px,
                  base::Instructions instructions,
                  cv::Mat& rim_px) {
    if (disparity_px.cols < 2 * kFar_px + base::kLanes) return;
    const auto mark = base::compiled_for<mark_row>(instructions);
    for (int v = kFar_px; v + kFar_px < disparity_px.rows; ++v)
        mark({disparity_px.ptr<float>(v),
              static_cast<std::ptrdiff_t>(disparity_px.step1()),
              sigma_px.ptr<float>(v),
              rim_px.ptr<float>(v),
              disparity_px.cols},
             static_cast<float>(focal_px));
}

}  // namespace divemesh::fusion
