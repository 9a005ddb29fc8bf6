#include "worker/camera/projection.hpp"

#include <algorithm>
#include <cmath>

#include "worker/camera/refraction.hpp"

namespace divemesh::camera {
namespace {

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

}  // namespace

bool is_fisheye(const types::Camera& camera) { return lens_model(camera.distortion).is_fisheye; }

std::optional<Eigen::Vector2d> project(const types::Camera& camera, const Eigen::Vector3d& p_cam) {
    const auto direction = camera.port ? direction_to(*camera.port, p_cam) : std::optional(p_cam);
    if (!direction || direction->z() <= 1e-6) return std::nullopt;
    const auto n = refract(camera.refractive_index, direction->head<2>() / direction->z());
    if (!n) return std::nullopt;
    const Eigen::Vector2d d =
        lens_model(camera.distortion).distort(camera.distortion_coefficients, *n);
    return Eigen::Vector2d(camera.fx_px * d.x() + camera.cx_px,
                           camera.fy_px * d.y() + camera.cy_px);
}

base::Ray sight_ray(const types::Camera& camera, const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d d((pixel.x() - camera.cx_px) / camera.fx_px,
                            (pixel.y() - camera.cy_px) / camera.fy_px);
    const Eigen::Vector2d n =
        refract_back(camera.refractive_index,
                     lens_model(camera.distortion).undistort(camera.distortion_coefficients, d));
    base::Ray ray{Eigen::Vector3d::Zero(), {n.x(), n.y(), 1.0}};
    if (!camera.port) return ray;
    const auto in_water = ray_in_water(*camera.port, ray.direction);
    // What does not pass the port goes on as it is: no pixel of a port that was checked does so.
    return in_water && in_water->direction.z() > 1e-6
               ? base::Ray{in_water->origin, in_water->direction / in_water->direction.z()}
               : ray;
}

Eigen::Vector3d unproject(const types::Camera& camera, const Eigen::Vector2d& pixel) {
    const base::Ray ray = sight_ray(camera, pixel);
    if (!camera.port) return ray.direction;
    const double depth_m = camera.port->reference_depth_m;
    return (ray.origin + (depth_m - ray.origin.z()) * ray.direction) / depth_m;
}

double axial_magnification(const types::Camera& camera) {
    if (!camera.port) return camera.refractive_index;
    constexpr double kStep_px = 1.0;
    const Eigen::Vector2d step(kStep_px, 0.0);
    const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
    const Eigen::Vector3d across =
        unproject(camera, centre + step) - unproject(camera, centre - step);
    return 2.0 * kStep_px / (camera.fx_px * across.x());
}

bool contains(const types::Camera& camera, const Eigen::Vector2d& pixel) {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera.width_px - 0.5 &&
           pixel.y() < camera.height_px - 0.5;
}

}  // namespace divemesh::camera
