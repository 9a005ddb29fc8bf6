#include "worker/tracking/first_look.hpp"

#include "worker/geometry/facing_warp.hpp"

namespace divemesh::worker {
namespace {

constexpr int kRadius_px = 16;  // of the surroundings: the patch turned and half as large again

}  // namespace

FirstLook::FirstLook(const RectifiedRig& rig, const cv::Mat& picture, const Feature& feature) {
    const cv::Point middle(static_cast<int>(feature.pixel.x()),
                           static_cast<int>(feature.pixel.y()));
    const cv::Rect around =
        cv::Rect(
            middle.x - kRadius_px, middle.y - kRadius_px, 2 * kRadius_px + 2, 2 * kRadius_px + 2) &
        cv::Rect(0, 0, picture.cols, picture.rows);
    surroundings_ = picture(around).clone();
    centre_px_ = feature.pixel - Eigen::Vector2d(around.x, around.y);
    if (has_depth(feature)) p_then_ = point_cam(rig, feature);
}

std::optional<Patch> FirstLook::from_here(const RectifiedRig& rig) const {
    if (!p_then_) return Patch::read(surroundings_, centre_px_);
    const auto warp = facing_warp(rig, *p_then_, T_now_then_);
    return warp ? Patch::read(surroundings_, centre_px_, *warp) : std::nullopt;
}

}  // namespace divemesh::worker
