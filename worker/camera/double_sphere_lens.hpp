#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

inline constexpr std::array<LeadingCoefficient, 2> kDoubleSphereLeading = {
    {{"xi", -0.9, 1.0}, {"alpha", 0.0, 1.0}}};

// A xi of either sign bends the image nearly alike, and least squares do not get from one to the
// other. Real lenses have a negative one.
inline constexpr std::array<types::LensCoefficients, 2> kDoubleSphereStarts = {
    {{-0.2, 0.55}, {0.2, 0.55}}};

inline double double_sphere_focal_factor(const types::LensCoefficients& k) { return 1.0 + k[0]; }

// xi alpha (Usenko, Demmel and Cremers 2018, equations 40 to 45).
template <typename Coefficients, typename T>
Eigen::Vector2<T> distort_double_sphere(const Coefficients& k, const Eigen::Vector2<T>& n) {
    using std::sqrt;
    const T xi = k[0];
    const T alpha = k[1];
    const T r2 = n.squaredNorm();
    const T z = 1.0 + xi * sqrt(1.0 + r2);
    return (1.0 + xi) / (alpha * sqrt(r2 + z * z) + (1.0 - alpha) * z) * n;
}

// Equations 46 to 50.
inline Eigen::Vector2d undistort_double_sphere(const types::LensCoefficients& k,
                                               const Eigen::Vector2d& d) {
    const double xi = k[0];
    const double alpha = k[1];
    const Eigen::Vector2d m = d / (1.0 + xi);
    const double r2 = m.squaredNorm();
    const double root = std::sqrt(std::max(0.0, 1.0 - (2.0 * alpha - 1.0) * r2));
    const double z = (1.0 - alpha * alpha * r2) / std::max(1e-12, alpha * root + (1.0 - alpha));
    const double scale =
        (z * xi + std::sqrt(std::max(0.0, z * z + (1.0 - xi * xi) * r2))) / (z * z + r2);
    return normalised({scale * m.x(), scale * m.y(), scale * z - xi});
}

inline constexpr LensModel kDoubleSphereLens = {.distortion = types::Distortion::DoubleSphere,
                                                .name = "double-sphere",
                                                .camera_model = "ds",
                                                .distortion_models = kNoDistortion,
                                                .num_coefficients = 2,
                                                .leading = kDoubleSphereLeading,
                                                .starts = kDoubleSphereStarts,
                                                .is_fisheye = true,
                                                .focal_factor = double_sphere_focal_factor,
                                                .distort = distort_double_sphere,
                                                .undistort = undistort_double_sphere};

}  // namespace divemesh::camera
