#include "worker/stereo/smooth_on_plane.hpp"

#include <algorithm>
#include <cstdlib>

#include "worker/base/lanes.hpp"
#include "worker/stereo/subpixel_refinement.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kRadius = 2;  // in strides
constexpr int kNumRows = 2 * kRadius + 1;
constexpr int kWideStride_px = 3;
constexpr float kMaxSlope = 1.0F;  // disparity per pixel; steeper is an edge
constexpr float kMaxGate_px = 0.8F;
constexpr float kCertain_px = 0.15F;  // a disparity with a smaller sigma is not changed
constexpr float kReach_px = 2 * kRadius * kWideStride_px + kWindow_px;
constexpr float kMaxWindows = kReach_px * kReach_px / (1.0F * kWindow_px * kWindow_px);
constexpr float kMaxOthers = kNumRows * kNumRows - 1;

static_assert(kRadius * kWideStride_px + base::kLanes <= PaddedDisparity::kMargin_px);

struct Mean {
    base::Floats value;
    base::Floats num_others;
};

// Averages the centre with the mirror pairs of neighbours, `stride` apart, that lie on one plane
// with it, within its gate.
DIVEMESH_INLINE_BODY Mean
mean_on_plane(const float* const* rows, int x, int stride, base::Floats center, base::Floats gate) {
    base::Floats sum = {};
    base::Floats count = {};
    for (int dy = 0; dy <= kRadius; ++dy) {
        for (int dx = -kRadius; dx <= kRadius; ++dx) {
            if (dy == 0 && dx <= 0) continue;
            const int across = dx * stride;
            const base::Floats ahead = base::load(rows[kRadius + dy] + x + across);
            const base::Floats behind = base::load(rows[kRadius - dy] + x - across);
            const base::Floats largest =
                gate + kMaxSlope * static_cast<float>(stride * std::max(dy, std::abs(dx)));
            const base::Floats up = ahead - center;
            const base::Floats down = behind - center;
            const base::Masks on_plane = (ahead > 0.0F) & (behind > 0.0F) &
                                         (base::abs(up) < largest) & (base::abs(down) < largest) &
                                         (base::abs(up + down) < 2.0F * gate);
            sum += base::select(on_plane, up + down);
            count += base::select(on_plane, base::broadcast(2.0F));
        }
    }
    return {center + base::select(center > 0.0F, sum / (1.0F + count)), count};
}

DIVEMESH_INLINE_BODY void smooth_row(const float* const* rows, float gate, int width, float* out) {
    for (int x = 0; x < width; x += base::kLanes) {
        const base::Floats center = base::load(rows[kRadius] + x);
        base::store(out + x,
                    base::any(center > 0.0F)
                        ? mean_on_plane(rows, x, 1, center, base::broadcast(gate)).value
                        : center);
    }
}

DIVEMESH_INLINE_BODY void smooth_uncertain_row(
    const float* const* rows, const float* sigmas, int width, float* out, float* out_sigmas) {
    for (int x = 0; x < width; x += base::kLanes) {
        const base::Floats center = base::load(rows[kRadius] + x);
        const base::Floats sigma = base::load(sigmas + x);
        const base::Masks uncertain = (center > 0.0F) & (sigma > kCertain_px);
        base::store(out + x, center);
        base::store(out_sigmas + x, sigma);
        if (!base::any(uncertain)) continue;
        const base::Floats gate =
            base::select(uncertain, base::min(2.0F * sigma, base::broadcast(kMaxGate_px)));
        const Mean mean = mean_on_plane(rows, x, kWideStride_px, center, gate);
        const base::Floats windows = 1.0F + (kMaxWindows - 1.0F) / kMaxOthers * mean.num_others;
        base::store(out + x, mean.value);
        const base::Masks apart = sigma < kWideSigma_px;
        base::store(out_sigmas + x,
                    base::select(apart, sigma / base::square_root(base::square_root(windows))) +
                        base::select(~apart, sigma));
    }
}

struct Rows {
    Rows(const PaddedDisparity& plane, int y, int stride) {
        for (int i = 0; i < kNumRows; ++i) begin[i] = plane.row(y + (i - kRadius) * stride);
    }
    const float* begin[kNumRows];
};

}  // namespace

void smooth_on_plane(const PaddedDisparity& disparity_px,
                     float gate_px,
                     PaddedDisparity& smooth_px,
                     base::Instructions instructions) {
    const auto smooth = base::compiled_for<smooth_row>(instructions);
    smooth_px.resize(disparity_px.size());
    for (int y = 0; y < disparity_px.height(); ++y)
        smooth(Rows(disparity_px, y, 1).begin, gate_px, disparity_px.width(), smooth_px.row(y));
}

void smooth_uncertain(const PaddedDisparity& disparity_px,
                      const PaddedDisparity& sigma_px,
                      PaddedDisparity& smooth_px,
                      PaddedDisparity& smooth_sigma_px,
                      base::Instructions instructions) {
    const auto smooth = base::compiled_for<smooth_uncertain_row>(instructions);
    smooth_px.resize(disparity_px.size());
    smooth_sigma_px.resize(disparity_px.size());
    for (int y = 0; y < disparity_px.height(); ++y)
        smooth(Rows(disparity_px, y, kWideStride_px).begin,
               sigma_px.row(y),
               disparity_px.width(),
               smooth_px.row(y),
               smooth_sigma_px.row(y));
}

}  // namespace divemesh::stereo
