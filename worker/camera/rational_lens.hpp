#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

// k1 k2 p1 p2 k3 k4 k5 k6, in OpenCV's order:
//     radial = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
template <typename Coefficients, typename T>
Eigen::Vector2<T> distort_rational(const Coefficients& k, const Eigen::Vector2<T>& n) {
    const T r2 = n.squaredNorm();
    const T radial = (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) /
                     (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    return radial * n + brown(T(0.0), T(0.0), k[2], k[3], n) - n;
}

inline Eigen::Vector2d undistort_rational(const types::LensCoefficients& k,
                                          const Eigen::Vector2d& d) {
    return inverse_by_newton([&](const Eigen::Vector2d& n) { return distort_rational(k, n); }, d);
}

inline constexpr LensModel kRationalLens = {.distortion = types::Distortion::Rational,
                                            .name = "rational",
                                            .camera_model = "pinhole",
                                            .distortion_models = kRadialTangentialNames,
                                            .num_coefficients = 8,
                                            .leading = {},
                                            .starts = kStraightStart,
                                            .is_fisheye = false,
                                            .focal_factor = same_focal_length,
                                            .distort = distort_rational,
                                            .undistort = undistort_rational};

}  // namespace divemesh::camera
