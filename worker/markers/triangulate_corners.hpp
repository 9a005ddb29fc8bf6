#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "worker/markers/marker_metrics.hpp"

namespace divemesh::markers {

using Corners = std::array<Eigen::Vector3d, dive::kNumTagCorners>;

// The corners of a tag in one image of an ideal camera with a fixed pose.
struct CornerView {
    std::size_t keyframe = 0;
    double focal_px = 0.0;
    Eigen::Vector2d principal_px = Eigen::Vector2d::Zero();
    Eigen::Isometry3d T_cam_world = Eigen::Isometry3d::Identity();
    std::array<Eigen::Vector2d, dive::kNumTagCorners> corners_px;

    // Returns the observed minus the projected position; nullopt if the point is behind the camera.
    std::optional<Eigen::Vector2d> residual_px(std::size_t corner,
                                               const Eigen::Vector3d& p_world) const;
    Eigen::Matrix<double, 2, 3> jacobian_px_per_m(const Eigen::Vector3d& p_world) const;
    // Returns the RMS over the corners; large if one is behind the camera.
    double rms_px(const Corners& corners_world) const;
};

// Triangulates each corner by itself: the point nearest to the rays, then Gauss-Newton on the
// reprojection error. Returns nullopt if the rays are too parallel, a corner ends up behind a
// camera, or the iterations do not converge.
std::optional<Corners> triangulate_corners(const std::vector<CornerView>& views);

struct CornerFit {
    double rms_px = 0.0;  // of one axis, corrected for the number of parameters
    CornerCovariance covariance_m2 = CornerCovariance::Zero();
};

// Returns the fit of triangulated corners. `views` must be sorted by keyframe.
CornerFit corner_covariance(const std::vector<CornerView>& views, const Corners& corners_world);

}  // namespace divemesh::markers
