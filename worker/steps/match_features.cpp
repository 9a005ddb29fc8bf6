#include "worker/steps/match_features.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "worker/steps/align_patch.hpp"

namespace divemesh::worker {
namespace {

constexpr double kLeastCorrelation = 0.8;
constexpr double kSmallestDisparity_px = 1.0;
constexpr int kRadius_px = 5;

constexpr int kNumPixels = (2 * kRadius_px + 1) * (2 * kRadius_px + 1);

int brightness(const cv::Mat& image, int u, int v) {
    int sum = 0;
    for (int dv = -kRadius_px; dv <= kRadius_px; ++dv) {
        const std::uint8_t* row = image.ptr<std::uint8_t>(v + dv) + u - kRadius_px;
        for (int du = 0; du <= 2 * kRadius_px; ++du) sum += row[du];
    }
    return sum;
}

// Sum of absolute differences of two squares around (u, v) and (u - disparity, v), after their
// mean brightness: the cameras may be exposed differently.
int difference(const RectifiedFrame& frame, int u, int v, int disparity) {
    const int offset =
        (brightness(frame.left, u, v) - brightness(frame.right, u - disparity, v)) / kNumPixels;
    int sum = 0;
    for (int dv = -kRadius_px; dv <= kRadius_px; ++dv) {
        const std::uint8_t* left = frame.left.ptr<std::uint8_t>(v + dv) + u - kRadius_px;
        const std::uint8_t* right =
            frame.right.ptr<std::uint8_t>(v + dv) + u - disparity - kRadius_px;
        for (int du = 0; du <= 2 * kRadius_px; ++du)
            sum += std::abs(int{left[du]} - int{right[du]} - offset);
    }
    return sum;
}

// The disparity of the best square in the row, whole pixels; 0 when another place is as good.
int search_row(const RectifiedFrame& frame, const Eigen::Vector2d& pixel, int num_disparities_px) {
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    if (v < kRadius_px || v >= frame.left.rows - kRadius_px || u < kRadius_px ||
        u >= frame.left.cols - kRadius_px)
        return 0;
    const int farthest = std::min(num_disparities_px, u - kRadius_px);
    if (farthest < 1) return 0;
    std::vector<int> cost(static_cast<std::size_t>(farthest) + 1);
    for (int d = 0; d <= farthest; ++d)
        cost[static_cast<std::size_t>(d)] = difference(frame, u, v, d);
    const int best = static_cast<int>(std::min_element(cost.begin(), cost.end()) - cost.begin());
    int second = std::numeric_limits<int>::max();
    for (int d = 0; d <= farthest; ++d)
        if (std::abs(d - best) > 2) second = std::min(second, cost[static_cast<std::size_t>(d)]);
    const bool unique = 10 * cost[static_cast<std::size_t>(best)] < 9 * std::int64_t{second};
    return unique ? best : 0;
}

double refine(const Patch& patch, const cv::Mat& right, const Feature& feature, double guess_px) {
    const auto found = patch.align(right, {feature.pixel.x() - guess_px, feature.pixel.y()}, true);
    if (!found || found->correlation < kLeastCorrelation) return 0.0;
    const double disparity = feature.pixel.x() - found->pixel.x();
    return disparity >= kSmallestDisparity_px ? disparity : 0.0;
}

double dense_at(const cv::Mat& dense_px, const Eigen::Vector2d& pixel) {
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    if (u < 0 || v < 0 || u >= dense_px.cols || v >= dense_px.rows) return 0.0;
    return dense_px.at<float>(v, u);
}

double measure(const RectifiedFrame& frame,
               const cv::Mat& dense_px,
               int num_disparities_px,
               const Feature& feature) {
    const auto patch = Patch::read(frame.left, feature.pixel);
    if (!patch) return 0.0;
    if (!dense_px.empty()) {  // the dense matcher has the say
        const double guess = dense_at(dense_px, feature.pixel);
        return guess > 0.0 ? refine(*patch, frame.right, feature, guess) : 0.0;
    }
    if (has_depth(feature)) {
        const double disparity = refine(*patch, frame.right, feature, feature.disparity_px);
        if (disparity > 0.0) return disparity;
    }
    const int found = search_row(frame, feature.pixel, num_disparities_px);
    return found > 0 ? refine(*patch, frame.right, feature, found) : 0.0;
}

}  // namespace

void match_features(const RectifiedFrame& frame,
                    const cv::Mat& dense_px,
                    int num_disparities_px,
                    Features& features) {
    for (Feature& feature : features)
        feature.disparity_px = measure(frame, dense_px, num_disparities_px, feature);
}

}  // namespace divemesh::worker
