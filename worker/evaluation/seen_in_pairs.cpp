#include "worker/evaluation/seen_in_pairs.hpp"

#include <algorithm>

#include "worker/camera/projection.hpp"

namespace divemesh::evaluation {
namespace {

constexpr std::size_t kRun = 32;  // consecutive cameras, which are close to each other
constexpr std::size_t kMaxPairs = 2000;
constexpr double kTolerance_m = 0.01;  // by which a ray may end in front of its point

// Returns the largest tangent of an angle to the axis that the image shows: that of a corner.
double tangent_of_corner(const types::Camera& camera) {
    double max = 0.0;
    for (const double u_px : {-0.5, camera.width_px - 0.5})
        for (const double v_px : {-0.5, camera.height_px - 0.5})
            max = std::max(max, camera::unproject(camera, {u_px, v_px}).head<2>().norm());
    return max;
}

}  // namespace

StereoPairs pairs_along(const types::Trajectory& trajectory, const types::Rig& rig) {
    StereoPairs pairs{rig, {}};
    for (const types::StampedPose& pose : trajectory)
        pairs.T_world_cam0.push_back(pose.T_world_imu * rig.T_imu_cam0);
    return pairs;
}

SeenInPairs::Eye::Eye(const types::Camera& of) : camera(of), max_tangent(tangent_of_corner(of)) {}

// Far outside the lens's field of view the distortion polynomial folds back into the image.
bool SeenInPairs::Eye::shows(const Eigen::Vector3d& p_cam) const {
    constexpr double kMargin = 1.02;
    if (p_cam.head<2>().norm() > kMargin * max_tangent * p_cam.z()) return false;
    const auto pixel = camera::project(camera, p_cam);
    return pixel && camera::contains(camera, *pixel);
}

SeenInPairs::SeenInPairs(const StereoPairs& pairs,
                         const Eigen::Isometry3d& T_surface_world,
                         const SurfaceIndex& surface,
                         double max_range_m)
    : left_(pairs.rig.cam0),
      right_(pairs.rig.cam1),
      T_cam1_cam0_(pairs.rig.T_cam1_cam0()),
      surface_(surface),
      max_range_m_(max_range_m) {
    const std::size_t step = 1 + pairs.T_world_cam0.size() / (kMaxPairs + 1);
    for (std::size_t i = 0; i < pairs.T_world_cam0.size(); i += step) {
        const Eigen::Isometry3d T_surface_cam0 = T_surface_world * pairs.T_world_cam0[i];
        if (T_cam0_surface_.size() % kRun == 0) boxes_.emplace_back();
        boxes_.back().extend(Eigen::Vector3d(T_surface_cam0.translation()));
        T_cam0_surface_.push_back(T_surface_cam0.inverse());
    }
}

bool SeenInPairs::is_seen(const Eigen::Vector3f& point, int min_pairs) const {
    const Eigen::Vector3d p = point.cast<double>();
    int num_pairs = 0;
    for (std::size_t run = 0; run < boxes_.size(); ++run) {
        if (boxes_[run].squaredExteriorDistance(p) > max_range_m_ * max_range_m_) continue;
        const std::size_t end = std::min(T_cam0_surface_.size(), (run + 1) * kRun);
        for (std::size_t i = run * kRun; i < end; ++i)
            if (pair_sees(T_cam0_surface_[i], p) && ++num_pairs >= min_pairs) return true;
    }
    return false;
}

bool SeenInPairs::pair_sees(const Eigen::Isometry3d& T_cam0_surface,
                            const Eigen::Vector3d& point) const {
    const Eigen::Vector3d p_cam0 = T_cam0_surface * point;
    if (p_cam0.squaredNorm() > max_range_m_ * max_range_m_ || !left_.shows(p_cam0) ||
        !right_.shows(T_cam1_cam0_ * p_cam0))
        return false;
    const Eigen::Isometry3d T_surface_cam0 = T_cam0_surface.inverse();
    return !is_hidden(T_surface_cam0.translation(), point) &&
           !is_hidden(T_surface_cam0 * T_cam1_cam0_.inverse().translation(), point);
}

bool SeenInPairs::is_hidden(const Eigen::Vector3d& camera, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d way = point - camera;
    const double distance_m = way.norm();
    const auto hit_m = surface_.first_hit_m(camera.cast<float>(), (way / distance_m).cast<float>());
    return hit_m && static_cast<double>(*hit_m) < distance_m - kTolerance_m;
}

}  // namespace divemesh::evaluation
