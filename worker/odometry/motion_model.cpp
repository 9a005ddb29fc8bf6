#include "worker/odometry/motion_model.hpp"

#include <algorithm>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"

namespace divemesh::odometry {
namespace {

// After this time a diver no longer moves as before.
constexpr double kMaxExtrapolation_s = 0.5;
// After this time without vision the error of a cheap IMU (0.1 m/s^2 with a bias that is hardly
// known) is as large as what a camera sees.
constexpr double kMaxCarried_s = 2.0;

}  // namespace

void MotionModel::start(std::int64_t timestamp_ns, const Eigen::Isometry3d& T_world_cam) {
    started_ = true;
    timestamp_ns_ = timestamp_ns;
    seen_ns_ = timestamp_ns;
    T_world_cam_ = T_world_cam;
}

bool MotionModel::is_lost(std::int64_t timestamp_ns) const {
    return seen_ns_ < timestamp_ns_ && base::to_s(timestamp_ns - seen_ns_) > kMaxCarried_s;
}

std::optional<types::KnownRotation> MotionModel::rotation(std::int64_t timestamp_ns) const {
    const Eigen::Quaterniond q_imu_cam(rig_.T_imu_cam.linear());
    const Eigen::Quaterniond q_world_cam(T_world_cam_.linear());
    const auto rotation_imu =
        inertial_.rotation_from(q_world_cam * q_imu_cam.conjugate(), timestamp_ns_, timestamp_ns);
    if (!rotation_imu) return std::nullopt;
    const Eigen::Quaterniond q_previous_current =
        q_imu_cam.conjugate() * rotation_imu->q * q_imu_cam;
    return types::KnownRotation{q_previous_current.conjugate(), rotation_imu->sigma_rad};
}

Eigen::Isometry3d MotionModel::predict(const std::optional<types::KnownRotation>& rotation,
                                       std::int64_t timestamp_ns) const {
    const bool lost = is_lost(timestamp_ns);
    if (inertial_state_ && !lost)
        if (const auto motion = inertial_.motion(timestamp_ns_, timestamp_ns))
            return predict_by_imu(*motion).inverse();
    Eigen::Isometry3d T_previous_current = steady_motion(timestamp_ns);
    if (rotation) T_previous_current.linear() = rotation->q.conjugate().toRotationMatrix();
    if (lost) T_previous_current.translation().setZero();
    return T_previous_current.inverse();
}

Eigen::Isometry3d MotionModel::steady_motion(std::int64_t timestamp_ns) const {
    const double interval_s =
        std::min(base::to_s(timestamp_ns - timestamp_ns_), kMaxExtrapolation_s);
    Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
    T_previous_current.linear() =
        base::rotation_from_vector(angular_velocity_cam_ * interval_s).toRotationMatrix();
    T_previous_current.translation() = velocity_cam_ * interval_s;
    return T_previous_current;
}

std::optional<double> MotionModel::imu_alone_s(std::int64_t timestamp_ns) const {
    if (!inertial_state_ || is_lost(timestamp_ns) || !inertial_.motion(timestamp_ns_, timestamp_ns))
        return std::nullopt;
    return base::to_s(timestamp_ns - inertial_state_->known_ns);
}

bool MotionModel::predicts_reliably(std::int64_t timestamp_ns) const {
    if (imu_alone_s(timestamp_ns)) return true;
    return base::to_s(timestamp_ns - timestamp_ns_) <= kMaxExtrapolation_s;
}

Eigen::Isometry3d MotionModel::predict_by_imu(const imu::PreintegratedImu& motion) const {
    const double dt_s = motion.rotation.duration_s;
    const Eigen::Isometry3d T_world_imu = T_world_cam_ * rig_.T_imu_cam.inverse();
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
    T_from_to.linear() = motion.rotation.q_from_to.toRotationMatrix();
    T_from_to.translation() =
        T_world_imu.linear().transpose() *
            (inertial_state_->velocity_world * dt_s +
             0.5 * imu::kGravity_m_s2 * dt_s * dt_s * inertial_state_->gravity_direction_world) +
        motion.delta_position;
    return rig_.T_imu_cam.inverse() * T_from_to * rig_.T_imu_cam;
}

void MotionModel::rest() {
    velocity_cam_.setZero();
    angular_velocity_cam_.setZero();
    if (inertial_state_) inertial_state_->velocity_world.setZero();
}

void MotionModel::advance(const Eigen::Isometry3d& T_current_previous, std::int64_t timestamp_ns) {
    const Eigen::Isometry3d T_previous_current = T_current_previous.inverse();
    const double interval_s = std::max(base::to_s(timestamp_ns - timestamp_ns_), 1e-6);
    if (is_lost(timestamp_ns)) inertial_state_.reset();
    if (inertial_state_) {
        const auto motion = inertial_.motion(timestamp_ns_, timestamp_ns);
        if (motion)
            inertial_state_->velocity_world += imu::kGravity_m_s2 * motion->rotation.duration_s *
                                                   inertial_state_->gravity_direction_world +
                                               T_world_cam_.linear() *
                                                   rig_.T_imu_cam.linear().transpose() *
                                                   motion->delta_velocity;
        else
            inertial_state_.reset();
    }
    const Eigen::Quaterniond turned(T_previous_current.linear());
    // In the new camera's frame, where the next step starts.
    velocity_cam_ = T_current_previous.linear() * T_previous_current.translation() / interval_s;
    angular_velocity_cam_ = base::vector_from_rotation(turned) / interval_s;
    T_world_cam_ = T_world_cam_ * T_previous_current;
    T_world_cam_.linear() =
        Eigen::Quaterniond(T_world_cam_.linear()).normalized().toRotationMatrix();
    timestamp_ns_ = timestamp_ns;
}

}  // namespace divemesh::odometry
