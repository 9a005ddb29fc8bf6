#include "worker/fusion/unshared_depth.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace divemesh::fusion {
namespace {

// Width of the border of an image that has no depth: windows do not reach it.
constexpr float kBorder_px = 6.0F;

// Marks the pixels of a row that the other frame has where it can measure depth. That is not the
// left border, whose counterpart lies outside its right image.
void find_shared(std::span<const SurfacePixel> row,
                 const types::RectifiedRig& rig,
                 const Eigen::Isometry3d& T_other_cam,
                 double v_px,
                 std::vector<std::uint8_t>& shared) {
    // The projection of a point at unit depth is linear in u.
    const Eigen::Matrix3f R = T_other_cam.linear().cast<float>();
    const Eigen::Vector3f t = T_other_cam.translation().cast<float>();
    const Eigen::Vector3f first = R * rig.point_cam(0.0, v_px, 1.0).cast<float>();
    const Eigen::Vector3f step = R.col(0) / static_cast<float>(rig.focal_px);
    const auto focal = static_cast<float>(rig.focal_px);
    const auto cx = static_cast<float>(rig.cx_px), cy = static_cast<float>(rig.cy_px);
    const float width = static_cast<float>(rig.width_px) - kBorder_px;
    const float height = static_cast<float>(rig.height_px) - kBorder_px;
    const auto disparity = static_cast<float>(rig.focal_px * rig.baseline_m);  // times z
    for (std::size_t i = 0; i < row.size(); ++i) {
        const auto u = static_cast<float>(i);
        const float depth = row[i].depth_m;
        const float x = depth * (first.x() + u * step.x()) + t.x();
        const float y = depth * (first.y() + u * step.y()) + t.y();
        const float z = depth * (first.z() + u * step.z()) + t.z();
        const float left = focal * x + cx * z, above = focal * y + cy * z;  // times z
        shared[i] |= static_cast<std::uint8_t>(
            static_cast<int>(z > static_cast<float>(types::RectifiedRig::kMinDepth_m)) &
            static_cast<int>(left >= kBorder_px * z + disparity) &
            static_cast<int>(above >= kBorder_px * z) & static_cast<int>(left < width * z) &
            static_cast<int>(above < height * z));
    }
}

}  // namespace

void mark_unshared(std::span<const Eigen::Isometry3d> T_other_cam, DepthView& view) {
    std::vector<std::uint8_t> shared(static_cast<std::size_t>(view.rig().width_px));
    for (int v = 0; v < view.rig().height_px; ++v) {
        const std::span<SurfacePixel> row = view.row(v);
        std::fill(shared.begin(), shared.end(), std::uint8_t{0});
        for (const Eigen::Isometry3d& T : T_other_cam) find_shared(row, view.rig(), T, v, shared);
        for (std::size_t u = 0; u < row.size(); ++u)
            if (shared[u] == 0) row[u].color |= SurfacePixel::kUnshared;
    }
}

}  // namespace divemesh::fusion
