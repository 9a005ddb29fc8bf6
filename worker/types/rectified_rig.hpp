#pragma once

#include <Eigen/Geometry>
#include <algorithm>

namespace divemesh::types {

// The ideal stereo pair after rectification: parallel image planes, aligned rows, no distortion.
// Frame `cam` below and in all steps is the rectified left camera (z forward, x to the right
// camera).
struct RectifiedRig {
    int width_px = 0;
    int height_px = 0;
    double focal_px = 0.0;
    double cx_px = 0.0;
    double cy_px = 0.0;
    double baseline_m = 0.0;
    Eigen::Isometry3d T_imu_cam = Eigen::Isometry3d::Identity();

    double depth_m(double disparity_px) const { return focal_px * baseline_m / disparity_px; }
    double disparity_px(double depth_m) const { return focal_px * baseline_m / depth_m; }
    Eigen::Vector3d point_cam(double u_px, double v_px, double depth) const {
        return {(u_px - cx_px) / focal_px * depth, (v_px - cy_px) / focal_px * depth, depth};
    }
    Eigen::Vector2d pixel(const Eigen::Vector3d& p_cam) const {
        return {focal_px * p_cam.x() / p_cam.z() + cx_px, focal_px * p_cam.y() / p_cam.z() + cy_px};
    }
    // Returns how far from the camera a point of the left image at a depth may be: in a corner.
    double range_m(double depth_m) const {
        const double u_px = std::max(cx_px + 0.5, width_px - 0.5 - cx_px);
        const double v_px = std::max(cy_px + 0.5, height_px - 0.5 - cy_px);
        return depth_m * Eigen::Vector3d(u_px / focal_px, v_px / focal_px, 1.0).norm();
    }
    // Returns true if a point is inside the left image and at least kMinDepth_m away.
    bool is_in_sight(const Eigen::Vector3d& p_cam) const {
        if (p_cam.z() < kMinDepth_m) return false;
        const Eigen::Vector2d at = pixel(p_cam);
        return at.x() >= 0.0 && at.y() >= 0.0 && at.x() < width_px && at.y() < height_px;
    }

    static constexpr double kMinDepth_m = 0.05;
};

}  // namespace divemesh::types
