#include "worker/stereo/plane_correlation.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "worker/stereo/disparity_sigma.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kNumSamples = PlaneCorrelation::Window::kNumSamples;
constexpr int kMargin_px = PlaneCorrelation::kMargin_px;
constexpr int kStride_px = 2;           // from sample to sample
constexpr float kMinTexture = 2.0F;     // standard deviation of the window over that of the noise
constexpr float kMinPeak = 0.02F;       // loss of correlation at 1 px
constexpr float kSimilar_grey = 20.0F;  // grey difference at which a sample counts 1/e
constexpr float kMinSigma_px = 0.3F;    // along the neighbour's epipolar line
constexpr float kMinDepth = 0.01F;      // in a neighbour, of the depth in the image to fill
constexpr float kNoPeak = 1e9F;         // a sigma

// Where the samples of a window are, from its centre.
struct Offsets {
    std::array<float, kNumSamples> u;
    std::array<float, kNumSamples> v;
};
constexpr Offsets kOffsets = [] {
    Offsets offsets{};
    std::size_t i = 0;
    for (int dv = -kMargin_px; dv <= kMargin_px; dv += kStride_px)
        for (int du = -kMargin_px; du <= kMargin_px; du += kStride_px, ++i) {
            offsets.u[i] = static_cast<float>(du);
            offsets.v[i] = static_cast<float>(dv);
        }
    return offsets;
}();

types::RectifiedRig reduced(types::RectifiedRig rig, int step_px) {
    rig.width_px /= step_px;
    rig.height_px /= step_px;
    rig.focal_px /= step_px;
    rig.cx_px = (rig.cx_px + 0.5) / step_px - 0.5;
    rig.cy_px = (rig.cy_px + 0.5) / step_px - 0.5;
    return rig;
}

cv::Mat reduced(const cv::Mat& image, const types::RectifiedRig& rig, int step_px) {
    cv::Mat small, values;
    const cv::Size size(rig.width_px, rig.height_px);
    cv::resize(image(cv::Rect({}, size * step_px)), small, size, 0.0, 0.0, cv::INTER_AREA);
    small.convertTo(values, CV_32F);
    return values;
}

// Maps the samples of the window to a view. Returns false if one is out of sight.
bool project(const ViewProjection& projection,
             int u,
             int v,
             const Plane& plane,
             cv::Size size,
             std::array<float, kNumSamples>& across,
             std::array<float, kNumSamples>& down) {
    const Eigen::Matrix3f& M = projection.M;
    const Eigen::Vector3f& m = projection.m;
    const Eigen::Vector3f from =
        M * Eigen::Vector3f(static_cast<float>(u), static_cast<float>(v), 1.0F) +
        m * plane.disparity_px;
    const Eigen::Vector3f step_u = M.col(0) + m * plane.slope_u;
    const Eigen::Vector3f step_v = M.col(1) + m * plane.slope_v;
    const auto max_u = static_cast<float>(size.width - 1);
    const auto max_v = static_cast<float>(size.height - 1);
    int num_seen = 0;
    for (std::size_t i = 0; i < kNumSamples; ++i) {
        const float du = kOffsets.u[i], dv = kOffsets.v[i];
        const float d = plane.disparity_px + plane.slope_u * du + plane.slope_v * dv;
        const float w = from.z() + step_u.z() * du + step_v.z() * dv;
        const float inverse = 1.0F / w;
        across[i] = (from.x() + step_u.x() * du + step_v.x() * dv) * inverse;
        down[i] = (from.y() + step_u.y() * du + step_v.y() * dv) * inverse;
        num_seen += static_cast<int>(d > 0.0F) & static_cast<int>(w > kMinDepth) &
                    static_cast<int>(across[i] >= 0.0F) & static_cast<int>(down[i] >= 0.0F) &
                    static_cast<int>(across[i] < max_u) & static_cast<int>(down[i] < max_v);
    }
    return num_seen == kNumSamples;
}

}  // namespace

PlaneCorrelation::PlaneCorrelation(const types::RectifiedRig& rig,
                                   const cv::Mat& left,
                                   std::span<const NeighbourView> neighbours,
                                   int step_px)
    : rig_(reduced(rig, step_px)), left_(reduced(left, rig_, step_px)) {
    for (const NeighbourView& neighbour : neighbours) {
        views_.push_back(reduced(neighbour.left, rig_, step_px));
        projections_.emplace_back(rig_, neighbour.T_other_cam);
    }
    cv::Mat grey;
    left_.convertTo(grey, CV_8U);
    min_deviation_ = kMinTexture * static_cast<float>(std::max(0.5, image_noise(grey)));
}

PlaneCorrelation::Window PlaneCorrelation::window_at(int u, int v) const {
    Window window;
    const float center = left_.at<float>(v, u);
    float sum = 0.0F, weights = 0.0F;
    int i = 0;
    for (int dv = -kMargin_px; dv <= kMargin_px; dv += kStride_px)
        for (int du = -kMargin_px; du <= kMargin_px; du += kStride_px, ++i) {
            const float value = left_.at<float>(v + dv, u + du);
            const float weight = std::exp(-std::abs(value - center) / kSimilar_grey);
            window.value[i] = value;
            window.weight[i] = weight;
            sum += weight * value;
            weights += weight;
        }
    const float mean = sum / weights;
    float squares = 0.0F;
    for (i = 0; i < kNumSamples; ++i) {
        window.weight[i] /= weights;
        window.value[i] -= mean;
        squares += window.weight[i] * window.value[i] * window.value[i];
    }
    window.variance = squares;
    return window;
}

// Returns 1 - correlation of the window with what a view shows of the plane; kWorst if a part
// is out of sight.
float PlaneCorrelation::cost_in(
    std::size_t view, const Window& window, int u, int v, const Plane& plane) const {
    const cv::Mat& image = views_[view];
    std::array<float, kNumSamples> across, down;
    if (!project(projections_[view], u, v, plane, image.size(), across, down)) return kWorst;
    float sum = 0.0F, squares = 0.0F, product = 0.0F;
    for (std::size_t i = 0; i < kNumSamples; ++i) {
        const int left = static_cast<int>(across[i]), top = static_cast<int>(down[i]);
        const float p = across[i] - static_cast<float>(left);
        const float q = down[i] - static_cast<float>(top);
        const float* above = image.ptr<float>(top) + left;
        const float* below = image.ptr<float>(top + 1) + left;
        const float value = (1.0F - q) * ((1.0F - p) * above[0] + p * above[1]) +
                            q * ((1.0F - p) * below[0] + p * below[1]);
        const float weighted = window.weight[i] * value;
        sum += weighted;
        squares += weighted * value;
        product += weighted * window.value[i];
    }
    const float variance = squares - sum * sum;
    if (variance < 0.25F * min_deviation_ * min_deviation_) return 1.0F;
    return 1.0F - product / std::sqrt(variance * window.variance);
}

PlaneCorrelation::Score PlaneCorrelation::score(const Window& window,
                                                int u,
                                                int v,
                                                const Plane& plane) const {
    std::array<float, kNumViews> best{};
    best.fill(kWorst);
    Score result;
    for (std::size_t view = 0; view < views_.size(); ++view) {
        const float cost = cost_in(view, window, u, v, plane);
        if (cost < best[0]) {
            best[1] = best[0];
            result.views[1] = result.views[0];
            best[0] = cost;
            result.views[0] = view;
        } else if (cost < best[1]) {
            best[1] = cost;
            result.views[1] = view;
        }
    }
    result.cost = best[1] >= kWorst ? kWorst : 0.5F * (best[0] + best[1]);
    return result;
}

float PlaneCorrelation::sigma_px(int u, int v, const Plane& plane) const {
    const Window window = window_at(u, v);
    const Score found = score(window, u, v, plane);
    const float shift = std::min(shift_px(found.views[0], u, v, plane.disparity_px),
                                 shift_px(found.views[1], u, v, plane.disparity_px));
    if (shift < 0.05F) return kNoPeak;
    Plane nearer = plane, farther = plane;
    nearer.disparity_px += 1.0F / shift;
    farther.disparity_px -= 1.0F / shift;
    float losses[2] = {0.0F, 0.0F};
    for (const std::size_t view : found.views) {
        losses[0] += 0.5F * std::min(1.0F, cost_in(view, window, u, v, nearer));
        losses[1] += 0.5F * std::min(1.0F, cost_in(view, window, u, v, farther));
    }
    const float least = std::min(losses[0], losses[1]) - found.cost;
    if (least < kMinPeak) return kNoPeak;
    const float curvature = losses[0] + losses[1] - 2.0F * found.cost;
    const float sigma_px =
        std::sqrt(2.0F * std::max(found.cost, 0.0F) / (0.5F * kNumSamples * curvature));
    return std::max(sigma_px, kMinSigma_px) / shift;
}

// Returns how far a pixel moves in a view per px of disparity.
float PlaneCorrelation::shift_px(std::size_t view, int u, int v, float disparity_px) const {
    const ViewProjection& projection = projections_[view];
    const Eigen::Vector3f pixel(static_cast<float>(u), static_cast<float>(v), 1.0F);
    const Eigen::Vector3f here = projection.M * pixel + projection.m * disparity_px;
    const Eigen::Vector3f there = here + projection.m * 0.1F;
    return 10.0F * (here.hnormalized() - there.hnormalized()).norm();
}

}  // namespace divemesh::stereo
