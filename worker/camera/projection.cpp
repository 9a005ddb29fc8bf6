#include "worker/camera/projection.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace divemesh::camera {
namespace {

// Returns distorted normalised image coordinates (Brown 1966; Kannala and Brandt 2006).
Eigen::Vector2d distort(const types::Camera& camera, const Eigen::Vector2d& n) {
    const auto& k = camera.distortion_coefficients;
    const double r2 = n.squaredNorm();
    switch (camera.distortion) {
        case types::Distortion::None: return n;
        case types::Distortion::RadialTangential: {
            const double radial = 1.0 + r2 * (k[0] + r2 * k[1]);
            return {
                n.x() * radial + 2.0 * k[2] * n.x() * n.y() + k[3] * (r2 + 2.0 * n.x() * n.x()),
                n.y() * radial + k[2] * (r2 + 2.0 * n.y() * n.y()) + 2.0 * k[3] * n.x() * n.y()};
        }
        case types::Distortion::Equidistant: {
            const double r = std::sqrt(r2);
            if (r < 1e-12) return n;
            const double theta = std::atan(r);
            const double t2 = theta * theta;
            return n * (theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r);
        }
    }
    return n;
}

// Returns normalised image coordinates behind a thin flat port, perpendicular to the axis, for
// those in front of it (Snell: the sine of the angle to the axis is multiplied by the index);
// nullopt where a ray does not pass.
std::optional<Eigen::Vector2d> refract(double index, const Eigen::Vector2d& n) {
    const double cosine2 = 1.0 - (index * index - 1.0) * n.squaredNorm();
    if (cosine2 <= 0.0) return std::nullopt;
    return index / std::sqrt(cosine2) * n;
}

// Returns the inverse of refract().
Eigen::Vector2d refract_back(double index, const Eigen::Vector2d& n) {
    const double index2 = index * index;
    return n / std::sqrt(std::max(1e-12, index2 + (index2 - 1.0) * n.squaredNorm()));
}

// Returns the angle to the axis of an equidistant lens at a distance from the principal point in
// focal lengths, by bisection: at most kMaxFisheyeAngle_rad, or the angle at which the polynomial
// stops increasing, which may happen outside the image.
double equidistant_angle_at(const std::array<double, 4>& k, double distance) {
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

// Returns normalised image coordinates without distortion: those of a fisheye by the angle to its
// axis, which is bounded, those of other lenses by Newton's method.
Eigen::Vector2d undistort(const types::Camera& camera, const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d d((pixel.x() - camera.cx_px) / camera.fx_px,
                            (pixel.y() - camera.cy_px) / camera.fy_px);
    if (is_fisheye(camera)) {
        const double distance = d.norm();
        const double angle = equidistant_angle_at(camera.distortion_coefficients, distance);
        return (distance < 1e-12 ? 1.0 : std::tan(angle) / distance) * d;
    }
    // Starts at the distorted point, then Newton with a numeric Jacobian: converges wherever the
    // model is invertible.
    Eigen::Vector2d n = d;
    for (int i = 0; i < 20; ++i) {
        const Eigen::Vector2d error = distort(camera, n) - d;
        if (error.squaredNorm() < 1e-24) break;
        constexpr double kStep = 1e-6;
        Eigen::Matrix2d J;
        J.col(0) = (distort(camera, n + Eigen::Vector2d(kStep, 0.0)) -
                    distort(camera, n - Eigen::Vector2d(kStep, 0.0))) /
                   (2.0 * kStep);
        J.col(1) = (distort(camera, n + Eigen::Vector2d(0.0, kStep)) -
                    distort(camera, n - Eigen::Vector2d(0.0, kStep))) /
                   (2.0 * kStep);
        if (std::abs(J.determinant()) < 1e-9) break;
        n -= J.inverse() * error;
    }
    return n;
}

}  // namespace

bool is_fisheye(const types::Camera& camera) {
    return camera.distortion == types::Distortion::Equidistant;
}

std::optional<Eigen::Vector2d> project(const types::Camera& camera, const Eigen::Vector3d& p_cam) {
    if (p_cam.z() <= 1e-6) return std::nullopt;
    const auto n = refract(camera.refractive_index, p_cam.head<2>() / p_cam.z());
    if (!n) return std::nullopt;
    const Eigen::Vector2d d = distort(camera, *n);
    return Eigen::Vector2d(camera.fx_px * d.x() + camera.cx_px,
                           camera.fy_px * d.y() + camera.cy_px);
}

Eigen::Vector3d unproject(const types::Camera& camera, const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d n = refract_back(camera.refractive_index, undistort(camera, pixel));
    return {n.x(), n.y(), 1.0};
}

bool contains(const types::Camera& camera, const Eigen::Vector2d& pixel) {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera.width_px - 0.5 &&
           pixel.y() < camera.height_px - 0.5;
}

}  // namespace divemesh::camera
