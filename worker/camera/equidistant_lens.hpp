#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

inline constexpr std::array<std::string_view, 3> kEquidistantNames = {
    "equidistant", "equi", "fisheye"};

// k1 k2 k3 k4 (Kannala and Brandt 2006).
template <typename Coefficients, typename T>
Eigen::Vector2<T> distort_equidistant(const Coefficients& k, const Eigen::Vector2<T>& n) {
    using std::atan;
    using std::sqrt;
    const T r2 = n.squaredNorm();
    if (r2 < 1e-24) return n;
    const T r = sqrt(r2);
    const T theta = atan(r);
    const T t2 = theta * theta;
    return n * (theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r);
}

// Returns the angle to the axis of an equidistant lens at a distance from the principal point in
// focal lengths, by bisection: at most kMaxFisheyeAngle_rad, or the angle at which the polynomial
// stops increasing, which may happen outside the image.
inline double equidistant_angle_at(const types::LensCoefficients& k, double distance) {
    const auto distance_at = [&](double angle) {
        const double t2 = angle * angle;
        return angle * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
    };
    constexpr int kNumSteps = 32;
    constexpr double kStep_rad = kMaxFisheyeAngle_rad / kNumSteps;
    double below = 0.0;
    double above = kStep_rad;
    for (int i = 1; i < kNumSteps && distance_at(above) < distance; ++i) {
        const double next = kStep_rad * (i + 1);
        if (distance_at(next) <= distance_at(above)) break;
        below = above;
        above = next;
    }
    for (int i = 0; i < 52; ++i) {
        const double middle = 0.5 * (below + above);
        (distance_at(middle) < distance ? below : above) = middle;
    }
    return 0.5 * (below + above);
}

inline Eigen::Vector2d undistort_equidistant(const types::LensCoefficients& k,
                                             const Eigen::Vector2d& d) {
    const double distance = d.norm();
    const double angle = equidistant_angle_at(k, distance);
    return (distance < 1e-12 ? 1.0 : std::tan(angle) / distance) * d;
}

inline constexpr LensModel kEquidistantLens = {.distortion = types::Distortion::Equidistant,
                                               .name = "equidistant",
                                               .camera_model = "pinhole",
                                               .distortion_models = kEquidistantNames,
                                               .num_coefficients = 4,
                                               .leading = {},
                                               .starts = kStraightStart,
                                               .is_fisheye = true,
                                               .focal_factor = same_focal_length,
                                               .distort = distort_equidistant,
                                               .undistort = undistort_equidistant};

}  // namespace divemesh::camera
