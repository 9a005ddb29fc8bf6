#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

// k1 k2 p1 p2 (Brown 1966).
template <typename Coefficients, typename T>
Eigen::Vector2<T> distort_radial_tangential(const Coefficients& k, const Eigen::Vector2<T>& n) {
    return brown(k[0], k[1], k[2], k[3], n);
}

inline Eigen::Vector2d undistort_radial_tangential(const types::LensCoefficients& k,
                                                   const Eigen::Vector2d& d) {
    return inverse_by_newton(
        [&](const Eigen::Vector2d& n) { return distort_radial_tangential(k, n); }, d);
}

inline constexpr LensModel kRadialTangentialLens = {
    .distortion = types::Distortion::RadialTangential,
    .name = "radial-tangential",
    .camera_model = "pinhole",
    .distortion_models = kRadialTangentialNames,
    .num_coefficients = 4,
    .leading = {},
    .starts = kStraightStart,
    .is_fisheye = false,
    .focal_factor = same_focal_length,
    .distort = distort_radial_tangential,
    .undistort = undistort_radial_tangential};

}  // namespace divemesh::camera
