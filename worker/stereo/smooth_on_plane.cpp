#include "worker/stereo/smooth_on_plane.hpp"

#include <algorithm>
#include <cstdlib>

#include "worker/base/lanes.hpp"
#include "worker/stereo/subpixel_refinement.hpp"

namespace divemesh::worker {
namespace {

constexpr int kRadius = 2;  // in strides
constexpr int kNumRows = 2 * kRadius + 1;
constexpr int kWideStride_px = 3;
constexpr float kMaxSlope = 1.0F;  // disparity per pixel; steeper is an edge
constexpr float kMaxGate_px = 0.8F;
constexpr float kCertain_px = 0.15F;  // a disparity this well known is left as it is
constexpr float kReach_px = 2 * kRadius * kWideStride_px + kWindow_px;
constexpr float kMaxWindows = kReach_px * kReach_px / (1.0F * kWindow_px * kWindow_px);
constexpr float kMaxOthers = kNumRows * kNumRows - 1;

static_assert(kRadius * kWideStride_px + kLanes <= PaddedDisparity::kMargin_px);

struct Mean {
    Floats value;
    Floats num_others;
};

// Mirror pairs of the neighbours, `stride` apart, that lie on one plane with the centre, within its
// gate, are averaged with it.
DIVEMESH_INLINE_BODY Mean
mean_on_plane(const float* const* rows, int x, int stride, Floats center, Floats gate) {
    Floats sum = {};
    Floats count = {};
    for (int dy = 0; dy <= kRadius; ++dy) {
        for (int dx = -kRadius; dx <= kRadius; ++dx) {
            if (dy == 0 && dx <= 0) continue;
            const Floats ahead = load(rows[kRadius + dy] + x + dx * stride);
            const Floats behind = load(rows[kRadius - dy] + x - dx * stride);
            const Floats largest =
                gate + kMaxSlope * static_cast<float>(stride * std::max(dy, std::abs(dx)));
            const Floats up = ahead - center;
            const Floats down = behind - center;
            const Masks on_plane = (ahead > 0.0F) & (behind > 0.0F) & (abs(up) < largest) &
                                   (abs(down) < largest) & (abs(up + down) < 2.0F * gate);
            sum += select(on_plane, up + down);
            count += select(on_plane, broadcast(2.0F));
        }
    }
    return {center + select(center > 0.0F, sum / (1.0F + count)), count};
}

DIVEMESH_INLINE_BODY void smooth_row(const float* const* rows, float gate, int width, float* out) {
    for (int x = 0; x < width; x += kLanes) {
        const Floats center = load(rows[kRadius] + x);
        store(
            out + x,
            any(center > 0.0F) ? mean_on_plane(rows, x, 1, center, broadcast(gate)).value : center);
    }
}

DIVEMESH_INLINE_BODY void smooth_uncertain_row(
    const float* const* rows, const float* sigmas, int width, float* out, float* out_sigmas) {
    for (int x = 0; x < width; x += kLanes) {
        const Floats center = load(rows[kRadius] + x);
        const Floats sigma = load(sigmas + x);
        const Masks uncertain = (center > 0.0F) & (sigma > kCertain_px);
        store(out + x, center);
        store(out_sigmas + x, sigma);
        if (!any(uncertain)) continue;
        const Floats gate = select(uncertain, min(2.0F * sigma, broadcast(kMaxGate_px)));
        const Mean mean = mean_on_plane(rows, x, kWideStride_px, center, gate);
        const Floats windows = 1.0F + (kMaxWindows - 1.0F) / kMaxOthers * mean.num_others;
        store(out + x, mean.value);
        const Masks apart = sigma < kWideSigma_px;
        store(out_sigmas + x,
              select(apart, sigma / square_root(square_root(windows))) + select(~apart, sigma));
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
                     Instructions instructions) {
    const auto smooth = compiled_for<smooth_row>(instructions);
    smooth_px.resize(disparity_px.size());
    for (int y = 0; y < disparity_px.height(); ++y)
        smooth(Rows(disparity_px, y, 1).begin, gate_px, disparity_px.width(), smooth_px.row(y));
}

void smooth_uncertain(const PaddedDisparity& disparity_px,
                      const PaddedDisparity& sigma_px,
                      PaddedDisparity& smooth_px,
                      PaddedDisparity& smooth_sigma_px,
                      Instructions instructions) {
    const auto smooth = compiled_for<smooth_uncertain_row>(instructions);
    smooth_px.resize(disparity_px.size());
    smooth_sigma_px.resize(disparity_px.size());
    for (int y = 0; y < disparity_px.height(); ++y)
        smooth(Rows(disparity_px, y, kWideStride_px).begin,
               sigma_px.row(y),
               disparity_px.width(),
               smooth_px.row(y),
               smooth_sigma_px.row(y));
}

}  // namespace divemesh::worker
