#include "worker/camera/undescribed_port.hpp"

#include <cmath>

namespace divemesh::camera {
namespace {

constexpr double kWaterIndex = 1.337;   // 1.333 in a lake, 1.342 in a cold sea
constexpr double kMaxSineInAir = 0.97;  // 76 degrees: rays that graze the glass show nothing

// Returns (tan a / tan t - n) for the tangent of an angle t to the axis in water.
double outwards(double tangent) {
    const double sine = tangent / std::hypot(1.0, tangent);
    const double sine_in_air = kWaterIndex * sine;
    if (sine_in_air > kMaxSineInAir) return 0.0;
    const double cosine_in_air = std::sqrt(1.0 - sine_in_air * sine_in_air);
    const double cosine = std::sqrt(1.0 - sine * sine);
    return kWaterIndex * (cosine / cosine_in_air - 1.0);
}

}  // namespace

Eigen::Vector2d shift_of_port(const types::RectifiedRig& rig,
                              const RectifiedLens& lens,
                              const Eigen::Vector2d& rectified_px,
                              double depth_m) {
    constexpr double kStep = 1e-4;  // of the distance from the axis
    const Eigen::Vector3d ray =
        lens.R_camera_rectified * rig.point_cam(rectified_px.x(), rectified_px.y(), 1.0);
    const Eigen::Vector3d moved((1.0 + kStep) * ray.x(), (1.0 + kStep) * ray.y(), ray.z());
    const Eigen::Vector2d by_share =
        (rig.pixel(lens.R_camera_rectified.transpose() * moved) - rectified_px) / kStep;
    return outwards(ray.head<2>().norm() / ray.z()) / depth_m * by_share;
}

}  // namespace divemesh::camera
