#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

inline constexpr std::array<std::string_view, 5> kOmnidirectionalNames = {
    "radial-tangential", "radtan", "plumb_bob", "none", ""};
// xi is 0 for a pinhole, 1 for a parabolic mirror; calibrations of weak distortion give more.
inline constexpr std::array<LeadingCoefficient, 1> kOmnidirectionalLeading = {{{"xi", -0.9, 20.0}}};
inline constexpr std::array<types::LensCoefficients, 1> kOmnidirectionalStart = {{{1.0}}};

// The focal lengths of the model are those behind the shifted centre.
inline double omnidirectional_focal_factor(const types::LensCoefficients& k) { return 1.0 + k[0]; }

// xi k1 k2 p1 p2 (Mei and Rives 2007): onto the unit sphere, from a centre that is xi behind that
// of the sphere onto a plane, and there radial-tangential distortion.
template <typename Coefficients, typename T>
Eigen::Vector2<T> distort_omnidirectional(const Coefficients& k, const Eigen::Vector2<T>& n) {
    using std::sqrt;
    const T xi = k[0];
    const T r2 = n.squaredNorm();
    const Eigen::Vector2<T> m = n / (1.0 + xi * sqrt(1.0 + r2));
    return (1.0 + xi) * brown(k[1], k[2], k[3], k[4], m);
}

inline Eigen::Vector2d undistort_omnidirectional(const types::LensCoefficients& k,
                                                 const Eigen::Vector2d& d) {
    const double xi = k[0];
    const Eigen::Vector2d m = inverse_by_newton(
        [&](const Eigen::Vector2d& p) { return brown(k[1], k[2], k[3], k[4], p); }, d / (1.0 + xi));
    const double r2 = m.squaredNorm();
    const double on_sphere =
        (xi + std::sqrt(std::max(0.0, 1.0 + (1.0 - xi * xi) * r2))) / (1.0 + r2);
    return normalised({on_sphere * m.x(), on_sphere * m.y(), on_sphere - xi});
}

inline constexpr LensModel kOmnidirectionalLens = {.distortion = types::Distortion::Omnidirectional,
                                                   .name = "omnidirectional",
                                                   .camera_model = "omni",
                                                   .distortion_models = kOmnidirectionalNames,
                                                   .num_coefficients = 5,
                                                   .leading = kOmnidirectionalLeading,
                                                   .starts = kOmnidirectionalStart,
                                                   .is_fisheye = true,
                                                   .focal_factor = omnidirectional_focal_factor,
                                                   .distort = distort_omnidirectional,
                                                   .undistort = undistort_omnidirectional};

}  // namespace divemesh::camera
