#include "worker/color/keyframe_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace divemesh::color {
namespace {

// The difference of measured depth and surface, as a share: a fish is farther off, errors are less.
constexpr float kMaxContradiction = 0.08F;
constexpr std::uint8_t kSaturated = 250;  // levels from which cameras clip, less what JPEG changes

}  // namespace

std::vector<mesh::TriangleRun> SeenSurface::runs_in_sight(const mesh::ImageCamera& camera) const {
    std::vector<mesh::TriangleRun> in_sight;
    for (const mesh::TriangleRun& run : runs)
        if (camera.may_see(run)) in_sight.push_back(run);
    return in_sight;
}

mesh::ImageCamera SeenSurface::camera_of(const types::Keyframe& keyframe) const {
    return {rig, keyframe.T_world_cam, rig.width_px, rig.height_px};
}

float eccentricity_of(const mesh::ImageCamera& camera, float u_px, float v_px) {
    const float right_px = static_cast<float>(camera.columns) - camera.cx_px;
    const float bottom_px = static_cast<float>(camera.rows) - camera.cy_px;
    const float corner_u_px = std::max(camera.cx_px, right_px);
    const float corner_v_px = std::max(camera.cy_px, bottom_px);
    const float du_px = u_px - camera.cx_px;
    const float dv_px = v_px - camera.cy_px;
    return (du_px * du_px + dv_px * dv_px) /
           (corner_u_px * corner_u_px + corner_v_px * corner_v_px);
}

Eigen::Vector3f ray_of(const mesh::ImageCamera& camera, int row, int column) {
    return {(static_cast<float>(column) + 0.5F - camera.cx_px) / camera.focal_px,
            (static_cast<float>(row) + 0.5F - camera.cy_px) / camera.focal_px,
            1.0F};
}

KeyframeView::KeyframeView(const SeenSurface& surface,
                           const types::Keyframe& keyframe,
                           const types::KeyframeImages& images,
                           int num_threads)
    : images_(images),
      focal_baseline_(static_cast<float>(surface.rig.focal_px * surface.rig.baseline_m)),
      camera_(surface.camera_of(keyframe)),
      position_world_(keyframe.T_world_cam.translation().cast<float>()),
      depth_(surface.mesh, surface.runs_in_sight(camera_), camera_, num_threads) {}

std::optional<SeenPoint> KeyframeView::seen_at(const Eigen::Vector3f& p_world,
                                               const Eigen::Vector3f& normal_world,
                                               int window_px) const {
    const Eigen::Vector3f pixel = camera_.project(p_world);
    if (pixel.z() <= 0.0F) return std::nullopt;
    const int reach_px = window_px / 2;
    const auto is_inside = [reach_px](float at_px, int size_px) {  // false for NaN
        return at_px >= static_cast<float>(reach_px) &&
               at_px < static_cast<float>(size_px - reach_px);
    };
    if (!is_inside(pixel.x(), camera_.columns) || !is_inside(pixel.y(), camera_.rows))
        return std::nullopt;
    const auto column = static_cast<int>(pixel.x());
    const auto row = static_cast<int>(pixel.y());
    const Eigen::Vector3f to_camera = position_world_ - p_world;
    const float range_m = to_camera.norm();
    const float depth_m = 1.0F / pixel.z();
    const float cosine = normal_world.dot(to_camera) / range_m;
    if (!(cosine >= kMinCosine) || !shows_surface(row, column, depth_m, reach_px) ||
        contradicts(row, column, depth_m))
        return std::nullopt;
    const std::optional<Rgb> light = mean_light(row, column, reach_px);
    if (!light) return std::nullopt;
    return SeenPoint{range_m, eccentricity_of(camera_, pixel.x(), pixel.y()), cosine, *light};
}

// Returns false if the corners or the middle of the window show something else.
bool KeyframeView::shows_surface(int row, int column, float depth_m, int reach_px) const {
    const auto is_surface = [&](int down, int right) {
        const float inverse = depth_.inverse_depth(row + down, column + right);
        return inverse > 0.0F && std::abs(inverse * depth_m - 1.0F) < kMaxDepthStep;
    };
    return is_surface(0, 0) && is_surface(-reach_px, -reach_px) &&
           is_surface(-reach_px, reach_px) && is_surface(reach_px, -reach_px) &&
           is_surface(reach_px, reach_px);
}

bool KeyframeView::contradicts(int row, int column, float depth_m) const {
    if (images_.depth.disparity_px.empty()) return false;
    const float disparity_px = images_.depth.disparity_px.at<float>(row, column);
    return disparity_px > 0.0F &&
           std::abs(focal_baseline_ / disparity_px - depth_m) > kMaxContradiction * depth_m;
}

std::optional<Rgb> KeyframeView::mean_light(int row, int column, int reach_px) const {
    const std::array<float, 256>& linear = linear_levels();
    Rgb sum = {};
    for (int y = row - reach_px; y <= row + reach_px; ++y)
        for (int x = column - reach_px; x <= column + reach_px; ++x) {
            const auto& bgr = images_.left_color.at<cv::Vec3b>(y, x);
            if (std::max({bgr[0], bgr[1], bgr[2]}) >= kSaturated) return std::nullopt;
            for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += linear[bgr[2 - c]];
        }
    const auto num = static_cast<float>((2 * reach_px + 1) * (2 * reach_px + 1));
    for (float& channel : sum) channel /= num;
    return sum;
}

}  // namespace divemesh::color
