#include "worker/stereo/combine_scales.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/base/lanes.hpp"
#include "worker/stereo/padded_disparity.hpp"
#include "worker/stereo/sigma_limits.hpp"

namespace divemesh::stereo {
namespace {

// All disparities in px of the full size, unless they are named half.
constexpr int kSilhouette_half_px = 5;    // reach of a window of the half size
constexpr float kFarther_half_px = 2.0F;  // behind a silhouette
constexpr float kSameSurface_half_px = 1.0F;
constexpr float kKnownSigma_px = 0.75F;  // less: measured by the narrow window
constexpr float kContradiction_px = 1.0F;
constexpr float kAgreement_sigmas = 2.5F;
constexpr float kDisagreement = 0.5F;  // sigma per px of difference
constexpr float kAddedSigma_px = 1.0F;
constexpr float kMaxSigma_px = 3.0F;

static_assert(base::kLanes <= PaddedDisparity::kMargin_px);

// Disparities of eight pixels, and their sigmas.
struct Estimates {
    base::Floats disparity_px;
    base::Floats sigma_px;
};

// Returns the disparities of the half size without those next to a farther surface.
PaddedDisparity without_silhouettes(const cv::Mat& disparity_px) {
    constexpr int kEdge = 2 * kSilhouette_half_px + 1;
    constexpr float kFar_px = 1e6F;
    cv::Mat known(disparity_px.size(), CV_32F);
    for (int y = 0; y < known.rows; ++y) {
        const float* disparities = disparity_px.ptr<float>(y);
        float* out = known.ptr<float>(y);
        for (int x = 0; x < known.cols; ++x)
            out[x] = disparities[x] > 0.0F ? disparities[x] : kFar_px;
    }
    cv::Mat min_disparity_px;
    cv::erode(known, min_disparity_px, cv::Mat::ones(kEdge, kEdge, CV_8U));
    PaddedDisparity result;
    result.resize(disparity_px.size());
    for (int y = 0; y < known.rows; ++y) {
        const float* disparities = disparity_px.ptr<float>(y);
        const float* min_px = min_disparity_px.ptr<float>(y);
        float* out = result.row(y);
        for (int x = 0; x < known.cols; ++x)
            out[x] = disparities[x] - min_px[x] > kFarther_half_px ? 0.0F : disparities[x];
    }
    return result;
}

// Pixel i of the full size lies between the pixels (i - 1) / 2, rounded down, and the next one of
// the half size. Returns its way from the first to the second; at the border, where one of the two
// is outside, it is at the other.
float part_of(int i, int num_half) {
    if (i == 0) return 1.0F;
    if (i >= 2 * num_half - 1) return 0.0F;
    return i % 2 == 0 ? 0.75F : 0.25F;
}

// The two rows of the half size around a row of the full size.
struct HalfRows {
    HalfRows(const PaddedDisparity& disparity, const PaddedDisparity& sigma, int y)
        : part(part_of(y, disparity.height())) {
        const int first = (y + 1) / 2 - 1;
        for (int j = 0; j < 2; ++j) {
            disparities[j] = disparity.row(first + j);
            sigmas[j] = sigma.row(first + j);
        }
        nearest = disparities[part < 0.5F ? 0 : 1];
    }

    const float* disparities[2];
    const float* sigmas[2];
    const float* nearest;  // the disparities of the nearer row
    float part;            // from the first to the second
};

// Return, for eight pixels of the full size, the first and the second pixel of the half size around
// each, from `at` on.
DIVEMESH_INLINE_BODY base::Floats firsts(const float* at) {
    const base::Floats values = base::load(at);
    return __builtin_shufflevector(values, values, 0, 1, 1, 2, 2, 3, 3, 4);
}
DIVEMESH_INLINE_BODY base::Floats seconds(const float* at) {
    const base::Floats values = base::load(at);
    return __builtin_shufflevector(values, values, 1, 2, 2, 3, 3, 4, 4, 5);
}

DIVEMESH_INLINE_BODY base::Floats either(base::Masks mask, base::Floats a, base::Floats b) {
    return base::select(mask, a) + base::select(~mask, b);
}

// Interpolates between those of four pixels that are on one surface with the nearest one. Not
// defined where that is unknown.
DIVEMESH_INLINE_BODY Estimates between(const HalfRows& rows,
                                       int first,
                                       base::Floats part,
                                       base::Floats nearest_px) {
    base::Floats weights = {}, sum = {}, sum_sigma = {};
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const float* disparities = rows.disparities[j] + first;
            const float* sigmas = rows.sigmas[j] + first;
            const base::Floats d = i == 0 ? firsts(disparities) : seconds(disparities);
            const base::Masks on_surface =
                (d > 0.0F) & (base::abs(d - nearest_px) <= kSameSurface_half_px);
            const base::Floats weight =
                (i == 0 ? 1.0F - part : part) * (j == 0 ? 1.0F - rows.part : rows.part);
            weights += base::select(on_surface, weight);
            sum += base::select(on_surface, weight * d);
            sum_sigma +=
                base::select(on_surface, weight * (i == 0 ? firsts(sigmas) : seconds(sigmas)));
        }
    return {2.0F * sum / weights,
            base::max(2.0F * sum_sigma / weights, base::broadcast(kMinSigma_px))};
}

// Adds the disagreement of the two sizes to a sigma.
DIVEMESH_INLINE_BODY base::Floats with_difference(base::Floats sigma_px,
                                                  base::Floats difference_px) {
    const base::Floats disagreement_px = kDisagreement * difference_px;
    return base::min(base::broadcast(kMaxSigma_px),
                     base::square_root(sigma_px * sigma_px + disagreement_px * disagreement_px));
}

// Returns the weighted mean where `full` and `half` agree and `full` is vague; else `full` with a
// sigma that their difference raises.
DIVEMESH_INLINE_BODY Estimates combined(const Estimates& full, const Estimates& half) {
    const base::Floats difference_px = half.disparity_px - full.disparity_px;
    const base::Floats variance_full = full.sigma_px * full.sigma_px;
    const base::Floats variance_half = half.sigma_px * half.sigma_px;
    const base::Floats variance = variance_full + variance_half;
    const base::Masks agree =
        (full.sigma_px > kKnownSigma_px) &
        (difference_px * difference_px < kAgreement_sigmas * kAgreement_sigmas * variance);
    const base::Floats mean_px = full.disparity_px + difference_px * variance_full / variance;
    const base::Floats mean_sigma_px = base::square_root(variance_full * variance_half / variance);
    const base::Floats sigma_px =
        with_difference(either(agree, mean_sigma_px, full.sigma_px), difference_px);
    return {either(agree, mean_px, full.disparity_px),
            either(agree, base::max(base::broadcast(kMinSigma_px), sigma_px), sigma_px)};
}

// Returns the half size alone; 0 where it is too vague.
DIVEMESH_INLINE_BODY Estimates alone(const Estimates& half) {
    const base::Floats sigma_px =
        base::square_root(half.sigma_px * half.sigma_px + kAddedSigma_px * kAddedSigma_px);
    const base::Masks good = sigma_px <= kMaxSigma_px;
    return {base::select(good, half.disparity_px), base::select(good, sigma_px)};
}

// Combines eight pixels from column x on, `part` on their way between columns of the half size.
DIVEMESH_INLINE_BODY void combine_lanes(
    const HalfRows& rows, int x, base::Floats part, float* disparities_px, float* sigmas_px) {
    const int first = x / 2 - 1;
    const base::Floats nearest_px =
        either(part < 0.5F, firsts(rows.nearest + first), seconds(rows.nearest + first));
    const base::Masks seen = nearest_px > 0.0F;
    if (!base::any(seen)) return;
    const Estimates half = between(rows, first, part, nearest_px);
    const Estimates full{base::load(disparities_px), base::load(sigmas_px)};
    const base::Masks known = full.disparity_px > 0.0F;
    const base::Masks confirmed =
        known & (full.sigma_px <= kKnownSigma_px) &
        (base::abs(half.disparity_px - full.disparity_px) <= kContradiction_px);
    const base::Masks changed = seen & ~confirmed;
    if (!base::any(changed)) return;
    const Estimates both = combined(full, half);
    const Estimates only_half = alone(half);
    base::store(
        disparities_px,
        either(
            changed, either(known, both.disparity_px, only_half.disparity_px), full.disparity_px));
    base::store(sigmas_px,
                either(changed, either(known, both.sigma_px, only_half.sigma_px), full.sigma_px));
}

DIVEMESH_INLINE_BODY void combine_row(
    const HalfRows& rows, const float* parts, int width, float* disparities_px, float* sigmas_px) {
    const int whole = width - width % base::kLanes;
    for (int x = 0; x < whole; x += base::kLanes)
        combine_lanes(rows, x, base::load(parts + x), disparities_px + x, sigmas_px + x);
    if (whole == width) return;
    // The last pixels are fewer than a vector, so they are combined in a copy.
    float last_disparities_px[base::kLanes] = {};
    float last_sigmas_px[base::kLanes] = {};
    std::copy(disparities_px + whole, disparities_px + width, last_disparities_px);
    std::copy(sigmas_px + whole, sigmas_px + width, last_sigmas_px);
    combine_lanes(rows, whole, base::load(parts + whole), last_disparities_px, last_sigmas_px);
    std::copy_n(last_disparities_px, width - whole, disparities_px + whole);
    std::copy_n(last_sigmas_px, width - whole, sigmas_px + whole);
}

}  // namespace

void combine_scales(const types::DepthMap& half,
                    types::DepthMap& full,
                    base::Instructions instructions) {
    const auto combine = base::compiled_for<combine_row>(instructions);
    const PaddedDisparity disparity = without_silhouettes(half.disparity_px);
    PaddedDisparity sigma;
    sigma.copy_from(half.sigma_disparity_px);
    const int width = full.disparity_px.cols;
    std::vector<float> parts(static_cast<std::size_t>(width + base::kLanes));
    for (int x = 0; x < width; ++x)
        parts[static_cast<std::size_t>(x)] = part_of(x, disparity.width());
    for (int y = 0; y < full.disparity_px.rows; ++y)
        combine(HalfRows(disparity, sigma, y),
                parts.data(),
                width,
                full.disparity_px.ptr<float>(y),
                full.sigma_disparity_px.ptr<float>(y));
}

}  // namespace divemesh::stereo
