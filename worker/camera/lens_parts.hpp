#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "worker/camera/lens_model.hpp"

// What several lens models share. Formulas that distort are templates, for derivatives by automatic
// differentiation: T is a number, `k` whatever holds the coefficients.
namespace divemesh::camera {

inline constexpr std::array<std::string_view, 2> kNoDistortion = {"none", ""};
inline constexpr std::array<std::string_view, 4> kRadialTangentialNames = {
    "radial-tangential", "radtan", "plumb_bob", "rational_polynomial"};

inline constexpr std::array<types::LensCoefficients, 1> kStraightStart = {};

inline double same_focal_length(const types::LensCoefficients&) { return 1.0; }

// Returns normalised image coordinates of a ray. Those beyond kMaxFisheyeAngle_rad are drawn back
// to it.
inline Eigen::Vector2d normalised(const Eigen::Vector3d& ray) {
    static const double kMaxTangent = std::tan(kMaxFisheyeAngle_rad);
    const double radius = ray.head<2>().norm();
    if (radius <= kMaxTangent * ray.z()) return ray.head<2>() / ray.z();
    return radius > 0.0 ? Eigen::Vector2d(kMaxTangent / radius * ray.head<2>())
                        : Eigen::Vector2d(Eigen::Vector2d::Zero());
}

// Returns coordinates with radial-tangential distortion (Brown 1966).
template <typename T>
Eigen::Vector2<T> brown(
    const T& k1, const T& k2, const T& p1, const T& p2, const Eigen::Vector2<T>& n) {
    const T r2 = n.squaredNorm();
    const T radial = 1.0 + r2 * (k1 + r2 * k2);
    return {n.x() * radial + 2.0 * p1 * n.x() * n.y() + p2 * (r2 + 2.0 * n.x() * n.x()),
            n.y() * radial + p1 * (r2 + 2.0 * n.y() * n.y()) + 2.0 * p2 * n.x() * n.y()};
}

// Returns the point that `distort` maps to `d`. Starts at the distorted point, then Newton with a
// numeric Jacobian: converges wherever the model is invertible.
template <typename Distort>
Eigen::Vector2d inverse_by_newton(const Distort& distort, const Eigen::Vector2d& d) {
    Eigen::Vector2d n = d;
    for (int i = 0; i < 20; ++i) {
        const Eigen::Vector2d error = distort(n) - d;
        if (error.squaredNorm() < 1e-24) break;
        constexpr double kStep = 1e-6;
        Eigen::Matrix2d J;
        J.col(0) =
            (distort(n + Eigen::Vector2d(kStep, 0.0)) - distort(n - Eigen::Vector2d(kStep, 0.0))) /
            (2.0 * kStep);
        J.col(1) =
            (distort(n + Eigen::Vector2d(0.0, kStep)) - distort(n - Eigen::Vector2d(0.0, kStep))) /
            (2.0 * kStep);
        if (std::abs(J.determinant()) < 1e-9) break;
        n -= J.inverse() * error;
    }
    return n;
}

}  // namespace divemesh::camera
