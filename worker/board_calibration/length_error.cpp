#include "worker/board_calibration/length_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/base/nearest_to_rays.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr std::array kDistances_m = {1.0, 2.0, 3.0};
constexpr double kBar = 0.2;     // length over distance
constexpr double kBorder = 0.1;  // of the image between its border and the place that counts
constexpr double kMinParallax = 1e-12;
constexpr double kStepSigmas = 0.1;  // of the numeric derivatives: the errors are linear there

// The pixels of a point in both cameras.
struct SeenPoint {
    Eigen::Vector2d left;
    Eigen::Vector2d right;
};

std::optional<SeenPoint> seen(const RigParameters& rig, const Eigen::Vector3d& p_cam0) {
    const auto left = camera::project(rig.cam0(), p_cam0);
    const auto right = camera::project(rig.cam1(), isometry_of(rig.T_cam1_cam0) * p_cam0);
    if (!left || !right || !camera::contains(rig.cam0(), *left) ||
        !camera::contains(rig.cam1(), *right))
        return std::nullopt;
    return SeenPoint{*left, *right};
}

std::optional<Eigen::Vector3d> triangulated(const RigParameters& rig, const SeenPoint& point) {
    const Eigen::Isometry3d T_cam0_cam1 = isometry_of(rig.T_cam1_cam0).inverse();
    return base::nearest_to_rays(
        {{Eigen::Vector3d::Zero(), camera::unproject(rig.cam0(), point.left)},
         {T_cam0_cam1.translation(),
          T_cam0_cam1.linear() * camera::unproject(rig.cam1(), point.right)}},
        kMinParallax);
}

std::optional<double> length_m(const RigParameters& rig, const SeenPoint& a, const SeenPoint& b) {
    const auto p_a = triangulated(rig, a);
    const auto p_b = triangulated(rig, b);
    if (!p_a || !p_b) return std::nullopt;
    return (*p_a - *p_b).norm();
}

// Returns the relative standard deviation of the length of a bar; nullopt if it is not seen.
std::optional<double> bar_error(const RigParameters& rig,
                                const RigCovariance& covariance,
                                const Eigen::Vector3d& center_cam0,
                                const Eigen::Vector3d& direction) {
    const Eigen::Vector3d half = 0.5 * kBar * center_cam0.norm() * direction;
    const auto a = seen(rig, center_cam0 - half);
    const auto b = seen(rig, center_cam0 + half);
    if (!a || !b) return std::nullopt;
    RigVector J(rig.size());
    for (int i = 0; i < rig.size(); ++i) {
        RigVector step = RigVector::Zero(rig.size());
        step[i] = kStepSigmas * std::sqrt(covariance(i, i));
        const auto longer = length_m(rig.changed_by(step), *a, *b);
        const auto shorter = length_m(rig.changed_by(-step), *a, *b);
        if (!longer || !shorter || !(step[i] > 0.0)) return std::nullopt;
        J[i] = (*longer - *shorter) / (2.0 * step[i]);
    }
    return std::sqrt(std::max(0.0, J.dot(covariance * J))) / (2.0 * half.norm());
}

// Returns the worst of three directions; nullopt if the bar is seen in none.
std::optional<double> error_at(const RigParameters& rig,
                               const RigCovariance& covariance,
                               const Eigen::Vector2d& pixel,
                               double distance_m) {
    const Eigen::Vector3d ray = camera::unproject(rig.cam0(), pixel).normalized();
    std::optional<double> worst;
    for (const Eigen::Vector3d& direction :
         {Eigen::Vector3d(Eigen::Vector3d::UnitY().cross(ray).normalized()),
          Eigen::Vector3d(Eigen::Vector3d::UnitX().cross(ray).normalized()),
          ray}) {
        const auto error = bar_error(rig, covariance, distance_m * ray, direction);
        if (error) worst = std::max(worst.value_or(0.0), *error);
    }
    return worst;
}

}  // namespace

std::vector<LengthError> length_errors(const RigParameters& rig, const RigCovariance& covariance) {
    const double right = rig.kind0.width_px - 1.0;
    const double bottom = rig.kind0.height_px - 1.0;
    const auto at = [&](double x, double y) { return Eigen::Vector2d(x * right, y * bottom); };
    std::vector<LengthError> errors;
    for (const double distance_m : kDistances_m) {
        LengthError error{distance_m, error_at(rig, covariance, at(0.5, 0.5), distance_m), {}};
        for (const auto& place :
             {at(kBorder, 0.5), at(1.0 - kBorder, 0.5), at(0.5, kBorder), at(0.5, 1.0 - kBorder)}) {
            const auto here = error_at(rig, covariance, place, distance_m);
            if (here) error.border = std::max(error.border.value_or(0.0), *here);
        }
        errors.push_back(error);
    }
    return errors;
}

}  // namespace divemesh::board_calibration
