#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace divemesh::worker {

enum class Distortion { None, RadialTangential, Equidistant };

// One camera as calibrated: pinhole with lens distortion, pixel centres at integers (OpenCV).
// Distortion coefficients: k1 k2 p1 p2 (radial-tangential) or k1 k2 k3 k4 (equidistant).
struct Camera {
    int width_px = 0;
    int height_px = 0;
    double fx_px = 0.0;
    double fy_px = 0.0;
    double cx_px = 0.0;
    double cy_px = 0.0;
    Distortion distortion = Distortion::RadialTangential;
    std::array<double, 4> distortion_coefficients = {0.0, 0.0, 0.0, 0.0};

    // Point in the camera frame (m, z forward) to pixel; nothing when it is not in front of it.
    // The pixel may lie outside the image.
    std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_cam) const;
    // Pixel to the ray through it, z = 1.
    Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;
    bool contains(const Eigen::Vector2d& pixel) const;
};

}  // namespace divemesh::worker
