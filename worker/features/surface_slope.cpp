#include "worker/features/surface_slope.hpp"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

namespace divemesh::features {
namespace {

constexpr int kRadius_px = 8;
constexpr int kSide_px = 2 * kRadius_px + 1;
constexpr int kNumPixels = kSide_px * kSide_px;
constexpr int kIterations = 3;
constexpr float kNoise = 3.0F;           // of the difference of two images, grey levels
constexpr float kMaxSlope_depth = 2.0F;  // depth over width: a larger slope is an edge

using Values = std::array<float, kNumPixels>;

struct DisparityPlane {
    float d = 0.0F;  // at the feature
    float by_u = 0.0F;
    float by_v = 0.0F;
};

// Reads the right image where the disparity plane maps the patch. Returns false if it leaves the
// image.
bool read_right(const cv::Mat& right, int u, int v, const DisparityPlane& plane, Values& values) {
    for (int y = -kRadius_px, i = 0; y <= kRadius_px; ++y) {
        const std::uint8_t* row = right.ptr<std::uint8_t>(v + y);
        for (int x = -kRadius_px; x <= kRadius_px; ++x, ++i) {
            const float at = static_cast<float>(u + x) - plane.d -
                             plane.by_u * static_cast<float>(x) -
                             plane.by_v * static_cast<float>(y);
            if (!(at >= 0.0F && at < static_cast<float>(right.cols - 1))) return false;
            const int column = static_cast<int>(at);
            const float share = at - static_cast<float>(column);
            values[static_cast<std::size_t>(i)] = (1.0F - share) * static_cast<float>(row[column]) +
                                                  share * static_cast<float>(row[column + 1]);
        }
    }
    return true;
}

// Adjusts `values` to the gain and bias of `like`. Returns false if they are not correlated.
bool relight(const Values& like, Values& values) {
    float sum = 0.0F;
    float squares = 0.0F;
    float like_sum = 0.0F;
    float products = 0.0F;
    for (std::size_t i = 0; i < values.size(); ++i) {
        sum += values[i];
        squares += values[i] * values[i];
        like_sum += like[i];
        products += values[i] * like[i];
    }
    const float covariance = products - sum * like_sum / kNumPixels;
    const float variance = squares - sum * sum / kNumPixels;
    if (!(covariance > 0.0F && variance > 0.0F)) return false;
    const float gain = covariance / variance;
    const float bias = (like_sum - gain * sum) / kNumPixels;
    for (float& value : values) value = gain * value + bias;
    return true;
}

// The left image around a feature, and its derivative along the row.
struct LeftPatch {
    Values values;
    Values gradient;
};

LeftPatch read_left(const cv::Mat& left, int u, int v) {
    LeftPatch patch;
    for (int y = -kRadius_px, i = 0; y <= kRadius_px; ++y) {
        const std::uint8_t* row = left.ptr<std::uint8_t>(v + y) + u;
        for (int x = -kRadius_px; x <= kRadius_px; ++x, ++i) {
            patch.values[static_cast<std::size_t>(i)] = row[x];
            patch.gradient[static_cast<std::size_t>(i)] =
                0.5F * static_cast<float>(row[x + 1] - row[x - 1]);
        }
    }
    return patch;
}

// Does one Gauss-Newton step; `prior` is the standard deviation of the slopes around 0.
void improve(const LeftPatch& left, const Values& right, float prior, DisparityPlane& plane) {
    constexpr float kWeight = 1.0F / (kNoise * kNoise);
    const float prior_weight = 1.0F / (prior * prior);
    Eigen::Matrix3f H = Eigen::Vector3f(0.0F, prior_weight, prior_weight).asDiagonal();
    Eigen::Vector3f g(0.0F, -prior_weight * plane.by_u, -prior_weight * plane.by_v);
    for (int y = -kRadius_px, i = 0; y <= kRadius_px; ++y) {
        for (int x = -kRadius_px; x <= kRadius_px; ++x, ++i) {
            const auto at = static_cast<std::size_t>(i);
            const Eigen::Vector3f J =
                left.gradient[at] *
                Eigen::Vector3f(1.0F, static_cast<float>(x), static_cast<float>(y));
            H += kWeight * J * J.transpose();
            g += kWeight * J * (right[at] - left.values[at]);
        }
    }
    const Eigen::Vector3f step = H.ldlt().solve(g);
    plane.d += step.x();
    plane.by_u += step.y();
    plane.by_v += step.z();
}

Eigen::Vector2d slope_of(const types::RectifiedFrame& frame,
                         const types::Feature& feature,
                         float prior) {
    const int u = static_cast<int>(std::lround(feature.pixel.x()));
    const int v = static_cast<int>(std::lround(feature.pixel.y()));
    if (u <= kRadius_px || v < kRadius_px || u + kRadius_px + 1 >= frame.left.cols ||
        v + kRadius_px >= frame.left.rows)
        return Eigen::Vector2d::Zero();
    const LeftPatch left = read_left(frame.left, u, v);
    DisparityPlane plane{
        static_cast<float>(frame.matched_px(feature.pixel, feature.disparity_px)), 0.0F, 0.0F};
    for (int iteration = 0; iteration < kIterations; ++iteration) {
        Values right;
        if (!read_right(frame.right, u, v, plane, right) || !relight(left.values, right))
            return Eigen::Vector2d::Zero();
        improve(left, right, prior, plane);
    }
    if (!(std::hypot(plane.by_u, plane.by_v) < kMaxSlope_depth * prior))
        return Eigen::Vector2d::Zero();
    return {plane.by_u, plane.by_v};
}

}  // namespace

void measure_slopes(const types::RectifiedRig& rig,
                    const types::RectifiedFrame& frame,
                    types::Features& features) {
    // At 45 degrees 1 / depth changes by 1 / (depth focal) per pixel, and the disparity in
    // proportion.
    for (types::Feature& feature : features)
        if (types::has_depth(feature))
            feature.disparity_slope =
                slope_of(frame, feature, static_cast<float>(feature.disparity_px / rig.focal_px));
}

}  // namespace divemesh::features
