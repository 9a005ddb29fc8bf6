#include "worker/tracking/first_look.hpp"

namespace divemesh::worker {
namespace {

constexpr double kLeastFacing = 0.1;  // cosine: seen at a more grazing angle it is not relied on
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
    if (!has_depth(feature)) return;
    p_then_ = point_cam(rig, feature);
    // 1 / depth is linear in the pixel over a plane, and the disparity proportional to it.
    const Eigen::Vector2d across = feature.disparity_slope / rig.baseline_m;
    plane_then_ << across, (1.0 - across.dot(p_then_->head<2>())) / p_then_->z();
}

FirstLook::FirstLook(const RectifiedRig& rig,
                     const cv::Mat& picture,
                     const Feature& feature,
                     const FirstLook& before)
    : FirstLook(rig, picture, feature) {
    if (!p_then_ || !before.p_then_) return;
    const Eigen::Vector3d normal = before.T_now_then_.linear() * before.plane_then_;
    const double distance = normal.dot(*p_then_);
    if (distance > kLeastFacing * normal.norm() * p_then_->norm()) plane_then_ = normal / distance;
}

std::optional<Patch> FirstLook::from_here(const RectifiedRig& rig,
                                          const Eigen::Isometry3d& T_current_previous) const {
    if (!p_then_) return Patch::read(surroundings_, centre_px_);
    const auto warp = plane_warp(rig, *p_then_, plane_then_, T_current_previous * T_now_then_);
    return warp ? Patch::read(surroundings_, centre_px_, *warp) : std::nullopt;
}

}  // namespace divemesh::worker
