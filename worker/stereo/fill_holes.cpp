#include "worker/stereo/fill_holes.hpp"

#include "worker/base/lanes.hpp"

namespace divemesh::worker {
namespace {

constexpr int kDirections[8][2] = {
    {1, 0}, {0, 1}, {1, 1}, {1, -1}, {2, 1}, {1, 2}, {2, -1}, {1, -2}};
constexpr int kDistances[3] = {1, 2, 4};
constexpr int kReach_px = 2 * kDistances[2];
// What a pair may differ by: each is known to half a pixel, and the surface between them leans by
// so much per pixel; more may be an edge.
constexpr float kPairNoise_px = 1.0F;
constexpr float kPairSlope = 1.0F / 16.0F;
constexpr float kAgreement_px = 2.0F;  // of winner and pair: each may be a pixel off
constexpr float kMinPairs = 3.0F;

static_assert(kReach_px + kLanes <= PaddedDisparity::kMargin_px);

// The mean of the pairs that agree with each winner, 0 where they are too few.
DIVEMESH_INLINE_BODY Floats supported(const float* const* rows, int x, Floats winner) {
    Floats sum = {};
    Floats count = {};
    for (const int distance : kDistances) {
        const float largest = kPairNoise_px + kPairSlope * 2.0F * static_cast<float>(distance);
        for (const auto& [dx, dy] : kDirections) {
            const Floats a = load(rows[kReach_px + distance * dy] + x + distance * dx);
            const Floats b = load(rows[kReach_px - distance * dy] + x - distance * dx);
            const Floats mean = 0.5F * (a + b);
            const Masks agree = (a > 0.0F) & (b > 0.0F) & (abs(a - b) <= largest) &
                                (abs(mean - winner) <= kAgreement_px);
            sum += select(agree, mean);
            count += select(agree, broadcast(1.0F));
        }
    }
    return select(count >= kMinPairs, sum / max(count, broadcast(1.0F)));
}

DIVEMESH_INLINE_BODY void fill_row(const float* const* rows, int width, float* out) {
    for (int x = 0; x < width; x += kLanes) {
        const Floats here = load(rows[kReach_px] + x);
        const Masks unconfirmed = here < 0.0F;
        if (!any(unconfirmed)) {
            store(out + x, here);
            continue;
        }
        const Floats mean = supported(rows, x, -here);
        const Masks filled = unconfirmed & (mean > 0.0F);
        store(out + x, select(filled, mean) + select(~filled, here));
    }
}

void fill(const PaddedDisparity& from, PaddedDisparity& to, Instructions instructions) {
    const auto fill_one = compiled_for<fill_row>(instructions);
    for (int y = 0; y < from.height(); ++y) {
        const float* rows[2 * kReach_px + 1];
        for (int i = 0; i <= 2 * kReach_px; ++i) rows[i] = from.row(y + i - kReach_px);
        fill_one(rows, from.width(), to.row(y));
    }
}

}  // namespace

void fill_holes(PaddedDisparity& disparity_px, PaddedDisparity& spare, Instructions instructions) {
    spare.resize(disparity_px.size());
    fill(disparity_px, spare, instructions);
    fill(spare, disparity_px, instructions);
    for (int y = 0; y < disparity_px.height(); ++y) {
        float* row = disparity_px.row(y);
        for (int x = 0; x < disparity_px.width(); ++x) row[x] = row[x] > 0.0F ? row[x] : 0.0F;
    }
}

}  // namespace divemesh::worker
