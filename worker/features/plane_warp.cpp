#include "worker/features/plane_warp.hpp"

#include <Eigen/LU>
#include <cmath>

namespace divemesh::features {
namespace {

constexpr double kMinDepth_m = 0.05;
constexpr double kMaxStretch = 2.5;  // for shrinking too

}  // namespace

std::optional<Eigen::Matrix2d> plane_warp(const types::RectifiedRig& rig,
                                          const Eigen::Vector3d& p_from,
                                          const Plane& plane_from,
                                          const Eigen::Isometry3d& T_to_from) {
    const Eigen::Vector3d p_to = T_to_from * p_from;
    if (p_to.z() < kMinDepth_m) return std::nullopt;
    // Points of the plane move by the homography R + t n^T.
    const Eigen::Matrix3d H = T_to_from.linear() + T_to_from.translation() * plane_from.transpose();
    const double step_m = p_from.z() / rig.focal_px;  // the width of a pixel
    const Eigen::Vector2d centre = rig.pixel(p_to);
    Eigen::Matrix2d to_by_from;
    for (int axis = 0; axis < 2; ++axis)
        to_by_from.col(axis) = rig.pixel(p_to + step_m * H.col(axis)) - centre;
    const Eigen::Matrix2d warp = to_by_from.inverse();
    const double area = std::abs(warp.determinant());
    if (!(area < kMaxStretch * kMaxStretch && area * kMaxStretch * kMaxStretch > 1.0))
        return std::nullopt;
    return warp;
}

}  // namespace divemesh::features
