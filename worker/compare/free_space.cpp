#include "worker/compare/free_space.hpp"

#include <algorithm>

#include "worker/compare/compared_segment.hpp"

namespace divemesh::compare {

std::optional<Views> read_views(const io::ReconstructionFolder& folder) {
    if (!std::filesystem::exists(folder.path() / "keyframes.json")) return std::nullopt;
    const io::KeyframeCamera camera = folder.keyframe_camera();
    Views views;
    views.focal_px = camera.focal_px;
    views.center_px = camera.center_px;
    views.size_px = camera.size_px;
    for (const io::KeyframePose& keyframe : compared_keyframes(folder))
        views.T_cam_world.push_back(keyframe.T_world_cam.inverse());
    return views;
}

bool is_free_space(const Views& views,
                   const evaluation::SurfaceIndex& surface,
                   const Eigen::Vector3d& p_world,
                   double behind_m) {
    return std::ranges::any_of(views.T_cam_world, [&](const Eigen::Isometry3d& T_cam_world) {
        const Eigen::Vector3d p_cam = T_cam_world * p_world;
        if (p_cam.z() <= 0.05) return false;
        const Eigen::Vector2d pixel =
            views.focal_px * p_cam.head<2>() / p_cam.z() + views.center_px;
        if ((pixel.array() < 0.0).any() || (pixel.array() >= views.size_px.array()).any())
            return false;
        const Eigen::Vector3d eye = T_cam_world.inverse().translation();
        const Eigen::Vector3d way = p_world - eye;
        const auto hit = surface.first_hit_m(eye.cast<float>(), way.normalized().cast<float>());
        return hit && static_cast<double>(*hit) > way.norm() + behind_m;
    });
}

}  // namespace divemesh::compare
