#include "worker/stereo/combine_scales.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

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

struct Estimate {
    float disparity_px = 0.0F;  // 0: unknown
    float sigma_px = 0.0F;
};

// Returns the disparities of the half size without those next to a farther surface.
cv::Mat without_silhouettes(const cv::Mat& disparity_px) {
    constexpr int kEdge = 2 * kSilhouette_half_px + 1;
    constexpr double kFar = 1e6;
    cv::Mat known = disparity_px.clone();
    known.setTo(kFar, disparity_px <= 0.0F);
    cv::Mat min_disparity_px;
    cv::erode(known, min_disparity_px, cv::Mat::ones(kEdge, kEdge, CV_8U));
    cv::Mat result = disparity_px.clone();
    result.setTo(0.0F, disparity_px - min_disparity_px > kFarther_half_px);
    return result;
}

// Where a pixel of the full size lies among those of the half size: between two of them, and nearer
// to one.
struct Place {
    int first = 0;
    float part = 0.0F;  // from the first to the second

    Place(int at_px, int num) {
        const float at = std::clamp(
            0.5F * (static_cast<float>(at_px) - 0.5F), 0.0F, static_cast<float>(num - 1));
        first = std::min(static_cast<int>(at), num - 2);
        part = at - static_cast<float>(first);
    }
    int nearest() const { return part < 0.5F ? first : first + 1; }
};

// The two rows of the half size around a row of the full size.
struct HalfRows {
    HalfRows(const cv::Mat& disparity, const cv::Mat& sigma, Place place)
        : nearest(disparity.ptr<float>(place.nearest())), part(place.part) {
        for (int j = 0; j < 2; ++j) {
            disparities[j] = disparity.ptr<float>(place.first + j);
            sigmas[j] = sigma.ptr<float>(place.first + j);
        }
    }

    // Interpolates between those of four pixels that are on one surface with the nearest one.
    Estimate at(Place column) const {
        const float nearest_px = nearest[column.nearest()];
        float weights = 0.0F, sum = 0.0F, sum_sigma = 0.0F;
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 2; ++i) {
                const float d = disparities[j][column.first + i];
                if (d <= 0.0F || std::abs(d - nearest_px) > kSameSurface_half_px) continue;
                const float weight =
                    (i == 0 ? 1.0F - column.part : column.part) * (j == 0 ? 1.0F - part : part);
                weights += weight;
                sum += weight * d;
                sum_sigma += weight * sigmas[j][column.first + i];
            }
        return {2.0F * sum / weights, std::max(2.0F * sum_sigma / weights, kMinSigma_px)};
    }

    const float* disparities[2];
    const float* sigmas[2];
    const float* nearest;  // the disparities of the nearer row
    float part;            // from the first to the second
};

// Adds the disagreement of the two sizes to a sigma.
float with_difference(float sigma_px, float difference_px) {
    const float disagreement_px = kDisagreement * difference_px;
    return std::min(kMaxSigma_px,
                    std::sqrt(sigma_px * sigma_px + disagreement_px * disagreement_px));
}

Estimate combined(const Estimate& full, const Estimate& half) {
    const float difference_px = half.disparity_px - full.disparity_px;
    if (full.sigma_px <= kKnownSigma_px) {
        if (std::abs(difference_px) <= kContradiction_px) return full;
        return {full.disparity_px, with_difference(full.sigma_px, difference_px)};
    }
    const float variance_full = full.sigma_px * full.sigma_px;
    const float variance_half = half.sigma_px * half.sigma_px;
    const float variance = variance_full + variance_half;
    if (difference_px * difference_px < kAgreement_sigmas * kAgreement_sigmas * variance) {
        const float sigma_px = std::sqrt(variance_full * variance_half / variance);
        return {full.disparity_px + difference_px * variance_full / variance,
                std::max(kMinSigma_px, with_difference(sigma_px, difference_px))};
    }
    return {full.disparity_px, with_difference(full.sigma_px, difference_px)};
}

Estimate alone(const Estimate& half) {
    const float sigma_px =
        std::sqrt(half.sigma_px * half.sigma_px + kAddedSigma_px * kAddedSigma_px);
    return sigma_px > kMaxSigma_px ? Estimate{} : Estimate{half.disparity_px, sigma_px};
}

}  // namespace

void combine_scales(const types::DepthMap& half, types::DepthMap& full) {
    const cv::Mat disparity = without_silhouettes(half.disparity_px);
    std::vector<Place> columns;
    for (int x = 0; x < full.disparity_px.cols; ++x) columns.emplace_back(x, disparity.cols);
    for (int y = 0; y < full.disparity_px.rows; ++y) {
        const HalfRows rows(disparity, half.sigma_disparity_px, Place(y, disparity.rows));
        float* disparities_px = full.disparity_px.ptr<float>(y);
        float* sigmas_px = full.sigma_disparity_px.ptr<float>(y);
        for (std::size_t x = 0; x < columns.size(); ++x) {
            if (rows.nearest[columns[x].nearest()] <= 0.0F) continue;
            const bool known = disparities_px[x] > 0.0F;
            const Estimate by_half = rows.at(columns[x]);
            const Estimate result =
                known ? combined({disparities_px[x], sigmas_px[x]}, by_half) : alone(by_half);
            disparities_px[x] = result.disparity_px;
            sigmas_px[x] = result.sigma_px;
        }
    }
}

}  // namespace divemesh::stereo
