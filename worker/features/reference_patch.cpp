#include "worker/features/reference_patch.hpp"

namespace divemesh::features {
namespace {

constexpr double kMinFacingCosine = 0.1;  // at a more grazing angle the plane is not used
constexpr int kRadius_px = 16;  // of the surroundings: a rotated patch, half as large again

}  // namespace

ReferencePatch::ReferencePatch(const types::RectifiedRig& rig,
                               const cv::Mat& image,
                               const types::Feature& feature) {
    const cv::Point middle(static_cast<int>(feature.pixel.x()),
                           static_cast<int>(feature.pixel.y()));
    const cv::Rect around =
        cv::Rect(
            middle.x - kRadius_px, middle.y - kRadius_px, 2 * kRadius_px + 2, 2 * kRadius_px + 2) &
        cv::Rect(0, 0, image.cols, image.rows);
    surroundings_ = image(around).clone();
    centre_px_ = feature.pixel - Eigen::Vector2d(around.x, around.y);
    if (!types::has_depth(feature)) return;
    p_reference_ = types::point_cam(rig, feature);
    // On a plane 1 / depth is linear in the pixel, and the disparity is proportional to it.
    const Eigen::Vector2d across = feature.disparity_slope / rig.baseline_m;
    plane_reference_ << across, (1.0 - across.dot(p_reference_->head<2>())) / p_reference_->z();
}

ReferencePatch::ReferencePatch(const types::RectifiedRig& rig,
                               const cv::Mat& image,
                               const types::Feature& feature,
                               const ReferencePatch& before)
    : ReferencePatch(rig, image, feature) {
    if (!p_reference_ || !before.p_reference_) return;
    const Eigen::Vector3d normal = before.T_current_reference_.linear() * before.plane_reference_;
    const double distance = normal.dot(*p_reference_);
    if (distance > kMinFacingCosine * normal.norm() * p_reference_->norm())
        plane_reference_ = normal / distance;
}

std::optional<Eigen::Matrix2d> ReferencePatch::warp(
    const types::RectifiedRig& rig, const Eigen::Isometry3d& T_current_previous) const {
    if (!p_reference_) return std::nullopt;
    return plane_warp(
        rig, *p_reference_, plane_reference_, T_current_previous * T_current_reference_);
}

std::optional<Patch> ReferencePatch::warp_to_current(
    const types::RectifiedRig& rig, const Eigen::Isometry3d& T_current_previous) const {
    if (!p_reference_) return Patch::read(surroundings_, centre_px_);
    const auto to_reference = warp(rig, T_current_previous);
    return to_reference ? Patch::read(surroundings_, centre_px_, *to_reference) : std::nullopt;
}

}  // namespace divemesh::features
