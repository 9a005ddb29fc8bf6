#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

inline constexpr std::array<LeadingCoefficient, 2> kExtendedUnifiedLeading = {
    {{"alpha", 0.0, 1.0}, {"beta", 1e-3, 100.0}}};

inline constexpr std::array<types::LensCoefficients, 1> kExtendedUnifiedStart = {{{0.5, 1.0}}};

// alpha beta (Khomutenko, Garcia and Martinet 2016).
template <typename Coefficients, typename T>
Eigen::Vector2<T> distort_extended_unified(const Coefficients& k, const Eigen::Vector2<T>& n) {
    using std::sqrt;
    const T alpha = k[0];
    const T r2 = n.squaredNorm();
    return n / (alpha * sqrt(k[1] * r2 + 1.0) + (1.0 - alpha));
}

inline Eigen::Vector2d undistort_extended_unified(const types::LensCoefficients& k,
                                                  const Eigen::Vector2d& d) {
    const double alpha = k[0];
    const double r2 = k[1] * d.squaredNorm();
    const double root = std::sqrt(std::max(0.0, 1.0 - (2.0 * alpha - 1.0) * r2));
    const double z = (1.0 - alpha * alpha * r2) / std::max(1e-12, alpha * root + (1.0 - alpha));
    return normalised({d.x(), d.y(), z});
}

inline constexpr LensModel kExtendedUnifiedLens = {.distortion = types::Distortion::ExtendedUnified,
                                                   .name = "extended-unified",
                                                   .camera_model = "eucm",
                                                   .distortion_models = kNoDistortion,
                                                   .num_coefficients = 2,
                                                   .leading = kExtendedUnifiedLeading,
                                                   .starts = kExtendedUnifiedStart,
                                                   .is_fisheye = true,
                                                   .focal_factor = same_focal_length,
                                                   .distort = distort_extended_unified,
                                                   .undistort = undistort_extended_unified};

}  // namespace divemesh::camera
