#include "worker/stereo/fill_holes.hpp"

#include "worker/base/lanes.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kDirections[8][2] = {
    {1, 0}, {0, 1}, {1, 1}, {1, -1}, {2, 1}, {1, 2}, {2, -1}, {1, -2}};
constexpr int kDistances[3] = {1, 2, 4};
constexpr int kReach_px = 2 * kDistances[2];
// The max difference of a pair: each disparity is known to half a pixel, and the surface between
// them may slant by this much per pixel. A larger difference may be an edge.
constexpr float kPairNoise_px = 1.0F;
constexpr float kPairSlope = 1.0F / 16.0F;
constexpr float kAgreement_px = 2.0F;  // of winner and pair: each may be off by a pixel
constexpr float kMinPairs = 3.0F;

static_assert(kReach_px + base::kLanes <= PaddedDisparity::kMargin_px);

// Returns the mean of the pairs that agree with each winner, 0 if there are too few.
DIVEMESH_INLINE_BODY base::Floats supported(const float* const* rows, int x, base::Floats winner) {
    base::Floats sum = {};
    base::Floats count = {};
    for (const int distance : kDistances) {
        const float largest = kPairNoise_px + kPairSlope * 2.0F * static_cast<float>(distance);
        for (const auto& [dx, dy] : kDirections) {
            const int across = distance * dx;
            const int down = distance * dy;
            const base::Floats a = base::load(rows[kReach_px + down] + x + across);
            const base::Floats b = base::load(rows[kReach_px - down] + x - across);
            const base::Floats mean = 0.5F * (a + b);
            const base::Masks agree = (a > 0.0F) & (b > 0.0F) & (base::abs(a - b) <= largest) &
                                      (base::abs(mean - winner) <= kAgreement_px);
            sum += base::select(agree, mean);
            count += base::select(agree, base::broadcast(1.0F));
        }
    }
    return base::select(count >= kMinPairs, sum / base::max(count, base::broadcast(1.0F)));
}

// Returns eight pixels of a row after a round: unconfirmed winners with support get its mean.
DIVEMESH_INLINE_BODY base::Floats filled(const float* const* rows, int x) {
    const base::Floats here = base::load(rows[kReach_px] + x);
    const base::Masks unconfirmed = here < 0.0F;
    if (!base::any(unconfirmed)) return here;
    const base::Floats mean = supported(rows, x, -here);
    const base::Masks is_filled = unconfirmed & (mean > 0.0F);
    return base::select(is_filled, mean) + base::select(~is_filled, here);
}

DIVEMESH_INLINE_BODY void fill_row(const float* const* rows, int width, float* out) {
    for (int x = 0; x < width; x += base::kLanes) base::store(out + x, filled(rows, x));
}

// The same; winners that are still unconfirmed become holes.
DIVEMESH_INLINE_BODY void fill_row_at_last(const float* const* rows, int width, float* out) {
    for (int x = 0; x < width; x += base::kLanes) {
        const base::Floats values = filled(rows, x);
        base::store(out + x, base::select(values > 0.0F, values));
    }
}

using FillRow = void (*)(const float* const* rows, int width, float* out);

void fill(FillRow fill_one, const PaddedDisparity& from, PaddedDisparity& to) {
    for (int y = 0; y < from.height(); ++y) {
        const float* rows[2 * kReach_px + 1];
        for (int i = 0; i <= 2 * kReach_px; ++i) rows[i] = from.row(y + i - kReach_px);
        fill_one(rows, from.width(), to.row(y));
    }
}

}  // namespace

void fill_holes(PaddedDisparity& disparity_px,
                PaddedDisparity& spare,
                base::Instructions instructions) {
    spare.resize(disparity_px.size());
    fill(base::compiled_for<fill_row>(instructions), disparity_px, spare);
    fill(base::compiled_for<fill_row_at_last>(instructions), spare, disparity_px);
}

}  // namespace divemesh::stereo
