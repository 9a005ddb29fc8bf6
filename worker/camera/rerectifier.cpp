#include "worker/camera/rerectifier.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "worker/base/parallel.hpp"
#include "worker/camera/disparity_at.hpp"

namespace divemesh::camera {
namespace {

std::array<RectifiedLens, 2> changed(std::array<RectifiedLens, 2> lenses,
                                     const std::array<types::LensChange, 2>& change) {
    for (std::size_t side = 0; side < 2; ++side)
        lenses[side].camera = changed_camera(lenses[side].camera, change[side]);
    return lenses;
}

// Returns the value at column `u` of a row, linearly interpolated; u >= 0.
float row_at(const cv::Mat& image, float u, int v) {
    const int left = std::min(static_cast<int>(u), image.cols - 2);
    const float share = u - static_cast<float>(left);
    const float* row = image.ptr<float>(v) + left;
    return (1.0F - share) * row[0] + share * row[1];
}

}  // namespace

Rerectifier::Rerectifier(const types::Rig& rig,
                         const types::RectifiedRig& rectified,
                         const std::array<types::LensChange, 2>& change)
    : rectified_(rectified), stated_(rectified_lenses(rig)), refined_(changed(stated_, change)) {}

Eigen::Vector2d Rerectifier::forward(std::size_t side, const Eigen::Vector2d& pixel) const {
    return refined_[side].rectified_px(rectified_, stated_[side].recorded_px(rectified_, pixel));
}

Eigen::Vector2d Rerectifier::back(std::size_t side, const Eigen::Vector2d& pixel) const {
    return stated_[side].rectified_px(rectified_, refined_[side].recorded_px(rectified_, pixel));
}

Eigen::Vector3d Rerectifier::moved(const Eigen::Vector3d& measured_px) const {
    const Eigen::Vector2d left = forward(0, measured_px.head<2>());
    if (measured_px.z() <= 0.0) return {left.x(), left.y(), measured_px.z()};
    const Eigen::Vector2d right = forward(1, {measured_px.x() - measured_px.z(), measured_px.y()});
    return {left.x(), left.y(), left.x() - right.x()};
}

KeyframeRerectifier::KeyframeRerectifier(const types::RectifiedRig& rectified,
                                         const Rerectifier& rerectifier,
                                         int num_threads)
    : source_x_(rectified.height_px, rectified.width_px, CV_32F),
      source_y_(rectified.height_px, rectified.width_px, CV_32F),
      nearest_(rectified.height_px, rectified.width_px, CV_32S),
      shift_right_(rectified.height_px, rectified.width_px, CV_32F) {
    base::for_each_index(
        num_threads, static_cast<std::size_t>(rectified.height_px), [&](std::size_t index) {
            const int v = static_cast<int>(index);
            for (int u = 0; u < rectified.width_px; ++u) {
                const Eigen::Vector2d pixel(u, v);
                const Eigen::Vector2d source = rerectifier.back(0, pixel);
                source_x_.at<float>(v, u) = static_cast<float>(source.x());
                source_y_.at<float>(v, u) = static_cast<float>(source.y());
                const auto column = static_cast<int>(std::lround(source.x()));
                const auto row = static_cast<int>(std::lround(source.y()));
                const bool seen = column >= 0 && row >= 0 && column < rectified.width_px &&
                                  row < rectified.height_px;
                nearest_.at<int>(v, u) = seen ? row * rectified.width_px + column : -1;
                shift_right_.at<float>(v, u) =
                    static_cast<float>(rerectifier.forward(1, pixel).x() - pixel.x());
            }
        });
}

types::KeyframeImages KeyframeRerectifier::moved(const types::KeyframeImages& images) const {
    types::KeyframeImages result;
    result.left_color = moved(images.left_color);
    const cv::Mat& disparity = images.depth.disparity_px;
    result.depth.disparity_px = cv::Mat::zeros(disparity.size(), CV_32F);
    result.depth.sigma_disparity_px = cv::Mat::zeros(disparity.size(), CV_32F);
    const float* old_px = disparity.ptr<float>();
    const float* old_sigma_px = images.depth.sigma_disparity_px.ptr<float>();
    for (int v = 0; v < disparity.rows; ++v) {
        const float* source_x = source_x_.ptr<float>(v);
        const float* source_y = source_y_.ptr<float>(v);
        const int* nearest = nearest_.ptr<int>(v);
        float* new_px = result.depth.disparity_px.ptr<float>(v);
        float* new_sigma_px = result.depth.sigma_disparity_px.ptr<float>(v);
        for (int u = 0; u < disparity.cols; ++u) {
            if (nearest[u] < 0 || old_px[nearest[u]] <= 0.0F) continue;
            const float right =
                source_x[u] - disparity_at(disparity, source_x[u], source_y[u], old_px[nearest[u]]);
            if (right < 0.0F || right > static_cast<float>(disparity.cols - 1)) continue;
            const int row = nearest[u] / disparity.cols;
            const float moved_px =
                static_cast<float>(u) - (right + row_at(shift_right_, right, row));
            if (moved_px <= 0.0F) continue;
            new_px[u] = moved_px;
            new_sigma_px[u] = old_sigma_px[nearest[u]];
        }
    }
    return result;
}

cv::Mat KeyframeRerectifier::moved(const cv::Mat& left) const {
    cv::Mat result;
    if (!left.empty()) cv::remap(left, result, source_x_, source_y_, cv::INTER_LINEAR);
    return result;
}

}  // namespace divemesh::camera
