#include "worker/camera/refraction.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace divemesh::camera {
namespace {

constexpr double kMinCosine = 1e-6;
constexpr double kStep = 1e-6;  // normalised image coordinates, as the next two
constexpr double kConverged = 1e-12;
constexpr double kMaxError = 1e-9;
constexpr int kMaxIterations = 30;

// Where a ray leaves a face, and the unit normal there, towards the water.
struct Passage {
    Eigen::Vector3d p_lens;
    Eigen::Vector3d normal;
};

// Returns where a ray from inside crosses a face that is `outward_m` farther out than the inner
// one.
std::optional<Passage> crossing(const types::Port& port, const base::Ray& ray, double outward_m) {
    if (port.shape == types::Port::Shape::Flat) {
        const double cosine = ray.direction.dot(port.normal);
        if (cosine < kMinCosine) return std::nullopt;
        const double way_m = (port.distance_m + outward_m - ray.origin.dot(port.normal)) / cosine;
        return Passage{ray.origin + way_m * ray.direction, port.normal};
    }
    const double radius_m = port.radius_m + outward_m;
    const Eigen::Vector3d from_centre = ray.origin - port.centre_m;
    const double along = from_centre.dot(ray.direction);
    const double root2 = along * along - from_centre.squaredNorm() + radius_m * radius_m;
    if (root2 < 0.0) return std::nullopt;
    const Eigen::Vector3d p_lens = ray.origin + (std::sqrt(root2) - along) * ray.direction;
    return Passage{p_lens, (p_lens - port.centre_m) / radius_m};
}

// Returns the unit direction behind a face; `ratio`: the index before it over that behind it.
// nullopt if the ray is reflected or does not come from inside.
std::optional<Eigen::Vector3d> refracted(const Eigen::Vector3d& direction,
                                         const Eigen::Vector3d& normal,
                                         double ratio) {
    const double cosine = direction.dot(normal);
    const double cosine2_behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if (cosine < kMinCosine || cosine2_behind < kMinCosine * kMinCosine) return std::nullopt;
    return ratio * direction + (std::sqrt(cosine2_behind) - ratio * cosine) * normal;
}

// Returns where the search for normalised image coordinates in air begins: at those of the same
// direction in the water, behind a flat port bent as at a thin one across the axis.
Eigen::Vector2d first_guess(const types::Port& port, const Eigen::Vector2d& in_water) {
    const double index2 = port.water_index * port.water_index;
    const double cosine2 = 1.0 - (index2 - 1.0) * in_water.squaredNorm();
    if (port.shape != types::Port::Shape::Flat || cosine2 < 0.1) return in_water;
    return port.water_index / std::sqrt(cosine2) * in_water;
}

}  // namespace

std::optional<base::Ray> ray_in_water(const types::Port& port, const Eigen::Vector3d& direction) {
    const base::Ray in_air{Eigen::Vector3d::Zero(), direction.normalized()};
    const auto inner = crossing(port, in_air, 0.0);
    if (!inner) return std::nullopt;
    const auto in_glass = refracted(in_air.direction, inner->normal, 1.0 / port.glass_index);
    if (!in_glass) return std::nullopt;
    const auto outer = crossing(port, {inner->p_lens, *in_glass}, port.thickness_m);
    if (!outer) return std::nullopt;
    const auto in_water = refracted(*in_glass, outer->normal, port.glass_index / port.water_index);
    if (!in_water) return std::nullopt;
    return base::Ray{port.p_lens_cam + outer->p_lens, *in_water};
}

std::optional<Eigen::Vector3d> direction_to(const types::Port& port, const Eigen::Vector3d& p_cam) {
    if (!(p_cam.z() > kMinCosine)) return std::nullopt;
    const Eigen::Vector2d wanted = p_cam.head<2>() / p_cam.z();
    // By how much the ray of normalised image coordinates n, in air, misses the point.
    const auto miss = [&](const Eigen::Vector2d& n) -> Eigen::Vector2d {
        const auto ray = ray_in_water(port, n.homogeneous());
        if (!ray || ray->direction.z() < kMinCosine) return 1e3 * n - wanted;
        const double way_m = (p_cam.z() - ray->origin.z()) / ray->direction.z();
        return (ray->origin + way_m * ray->direction).head<2>() / p_cam.z() - wanted;
    };
    Eigen::Vector2d n = first_guess(port, wanted);
    Eigen::Vector2d error = miss(n);
    Eigen::Matrix2d J;
    for (int axis = 0; axis < 2; ++axis)
        J.col(axis) = (miss(n + kStep * Eigen::Vector2d::Unit(axis)) - error) / kStep;
    for (int i = 0; i < kMaxIterations && error.squaredNorm() > kConverged * kConverged; ++i) {
        const Eigen::Vector2d step = -J.inverse() * error;
        const Eigen::Vector2d error_there = miss(n + step);
        J += error_there * step.transpose() / step.squaredNorm();
        n += step;
        error = error_there;
    }
    if (!(error.norm() < kMaxError)) return std::nullopt;
    return Eigen::Vector3d(n.homogeneous());
}

}  // namespace divemesh::camera
