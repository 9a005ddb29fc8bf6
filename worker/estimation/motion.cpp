#include "worker/estimation/motion.hpp"

#include <algorithm>

#include "worker/geometry/rotation_vector.hpp"

namespace divemesh::worker {
namespace {

// Longer than this nobody swims on as before.
constexpr double kLongestExtrapolation_s = 0.5;

double seconds(std::int64_t interval_ns) { return 1e-9 * static_cast<double>(interval_ns); }

}  // namespace

void Motion::start(std::int64_t timestamp_ns, const Eigen::Isometry3d& T_world_cam) {
    started_ = true;
    timestamp_ns_ = timestamp_ns;
    T_world_cam_ = T_world_cam;
}

std::optional<KnownRotation> Motion::turn(std::int64_t timestamp_ns) const {
    const Eigen::Quaterniond q_imu_cam(rig_.T_imu_cam.linear());
    const Eigen::Quaterniond q_world_cam(T_world_cam_.linear());
    const auto turn_imu =
        inertial_.turn_from(q_world_cam * q_imu_cam.conjugate(), timestamp_ns_, timestamp_ns);
    if (!turn_imu) return std::nullopt;
    const Eigen::Quaterniond q_previous_current = q_imu_cam.conjugate() * turn_imu->q * q_imu_cam;
    return KnownRotation{q_previous_current.conjugate(), turn_imu->sigma_rad};
}

Eigen::Isometry3d Motion::expect(const std::optional<KnownRotation>& turn,
                                 std::int64_t timestamp_ns) const {
    if (fall_)
        if (const auto motion = inertial_.motion(timestamp_ns_, timestamp_ns))
            return by_inertia(*motion).inverse();
    const double interval_s =
        std::min(seconds(timestamp_ns - timestamp_ns_), kLongestExtrapolation_s);
    Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
    T_previous_current.linear() =
        (turn ? turn->q.conjugate() : rotation_from_vector(turn_rate_cam_ * interval_s))
            .toRotationMatrix();
    T_previous_current.translation() = velocity_cam_ * interval_s;
    return T_previous_current.inverse();
}

Eigen::Isometry3d Motion::by_inertia(const PreintegratedImu& motion) const {
    const double dt_s = motion.turn.duration_s;
    const Eigen::Isometry3d T_world_imu = T_world_cam_ * rig_.T_imu_cam.inverse();
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
    T_from_to.linear() = motion.turn.q_from_to.toRotationMatrix();
    T_from_to.translation() =
        T_world_imu.linear().transpose() *
            (fall_->velocity_world * dt_s + 0.5 * kGravity_m_s2 * dt_s * dt_s * fall_->down_world) +
        motion.position_change;
    return rig_.T_imu_cam.inverse() * T_from_to * rig_.T_imu_cam;
}

void Motion::advance(const Eigen::Isometry3d& T_current_previous, std::int64_t timestamp_ns) {
    const Eigen::Isometry3d T_previous_current = T_current_previous.inverse();
    const double interval_s = std::max(seconds(timestamp_ns - timestamp_ns_), 1e-6);
    if (fall_) {
        const auto motion = inertial_.motion(timestamp_ns_, timestamp_ns);
        if (motion)
            fall_->velocity_world += kGravity_m_s2 * motion->turn.duration_s * fall_->down_world +
                                     T_world_cam_.linear() * rig_.T_imu_cam.linear().transpose() *
                                         motion->velocity_change;
        else
            fall_.reset();
    }
    const Eigen::Quaterniond turned(T_previous_current.linear());
    // In the frame of the new camera, from where the next step is reckoned.
    velocity_cam_ = T_current_previous.linear() * T_previous_current.translation() / interval_s;
    turn_rate_cam_ = vector_from_rotation(turned) / interval_s;
    T_world_cam_ = T_world_cam_ * T_previous_current;
    T_world_cam_.linear() =
        Eigen::Quaterniond(T_world_cam_.linear()).normalized().toRotationMatrix();
    timestamp_ns_ = timestamp_ns;
}

}  // namespace divemesh::worker
