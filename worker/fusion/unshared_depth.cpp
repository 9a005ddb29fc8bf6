#include "worker/fusion/unshared_depth.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace divemesh::fusion {
namespace {

constexpr float kBorder_px = 6.0F;    // of an image, without depth: windows do not reach it
constexpr int kReach = 1;             // of the disparities around a pixel, in steps
constexpr int kMinMeasured = 2;       // of the disparities within reach; one alone may be chance
constexpr float kHiddenShare = 0.1F;  // by which nearer surface has more disparity
constexpr float kHidden_px = 2.0F;

// Returns whether a frame measured the surface at a pixel, or looked through it. What is nearer
// hides it.
bool has_measured(const OtherFrame& other, float u_px, float v_px, float disparity_px) {
    const cv::Mat& known = other.disparity_px;
    const int x = static_cast<int>(u_px) / other.step_px;
    const int y = static_cast<int>(v_px) / other.step_px;
    const float hidden_px = disparity_px * (1.0F + kHiddenShare) + kHidden_px;
    int measured = 0;
    for (int j = std::max(0, y - kReach); j <= std::min(known.rows - 1, y + kReach); ++j) {
        const float* row = known.ptr<float>(j);
        for (int i = std::max(0, x - kReach); i <= std::min(known.cols - 1, x + kReach); ++i)
            measured += static_cast<int>(row[i] > 0.0F && row[i] < hidden_px);
    }
    return measured >= kMinMeasured;
}

// Marks the pixels of a row whose surface the other frame measured. At the left border, whose
// counterpart lies outside its right image, it cannot.
void find_shared(const DepthView& view,
                 int v_px,
                 const OtherFrame& other,
                 std::vector<std::uint8_t>& shared) {
    const types::RectifiedRig& rig = view.rig();
    const std::span<const SurfacePixel> row = view.row(v_px);
    const auto pixels = static_cast<float>(view.step_px());  // of the frame, per pixel of the view
    // The projection of a point at unit depth is linear in u.
    const Eigen::Matrix3f R = other.T_other_cam.linear().cast<float>();
    const Eigen::Vector3f t = other.T_other_cam.translation().cast<float>();
    const Eigen::Vector3f first = R * rig.point_cam(0.0, v_px, 1.0).cast<float>();
    const Eigen::Vector3f step = R.col(0) / static_cast<float>(rig.focal_px);
    const auto focal = static_cast<float>(rig.focal_px);
    const auto cx = static_cast<float>(rig.cx_px), cy = static_cast<float>(rig.cy_px);
    const float width = static_cast<float>(rig.width_px) - kBorder_px;
    const float height = static_cast<float>(rig.height_px) - kBorder_px;
    const auto disparity = static_cast<float>(rig.focal_px * rig.baseline_m);  // times z
    for (std::size_t i = 0; i < row.size(); ++i) {
        if (shared[i] != 0 || row[i].weight <= 0.0F) continue;
        const auto u = static_cast<float>(i);
        const float depth = row[i].depth_m;
        const float x = depth * (first.x() + u * step.x()) + t.x();
        const float y = depth * (first.y() + u * step.y()) + t.y();
        const float z = depth * (first.z() + u * step.z()) + t.z();
        const float left = focal * x + cx * z, above = focal * y + cy * z;  // times z
        const bool is_in_sight = z > static_cast<float>(types::RectifiedRig::kMinDepth_m) &&
                                 left >= kBorder_px * z + disparity && above >= kBorder_px * z &&
                                 left < width * z && above < height * z;
        shared[i] = static_cast<std::uint8_t>(
            is_in_sight &&
            has_measured(other, pixels * left / z, pixels * above / z, pixels * disparity / z));
    }
}

}  // namespace

void mark_unshared(std::span<const OtherFrame> others, DepthView& view) {
    std::vector<std::uint8_t> shared(static_cast<std::size_t>(view.rig().width_px));
    for (int v = 0; v < view.rig().height_px; ++v) {
        std::fill(shared.begin(), shared.end(), std::uint8_t{0});
        for (const OtherFrame& other : others) find_shared(view, v, other, shared);
        const std::span<SurfacePixel> row = view.row(v);
        for (std::size_t u = 0; u < row.size(); ++u)
            if (shared[u] == 0) row[u].color |= SurfacePixel::kUnshared;
    }
}

}  // namespace divemesh::fusion
