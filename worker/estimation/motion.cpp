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

std::optional<KnownRotation> Motion::turn(const InertialPrior& inertial,
                                          std::int64_t timestamp_ns) const {
    const auto turn_imu = inertial.turn(timestamp_ns_, timestamp_ns);
    if (!turn_imu) return std::nullopt;
    const Eigen::Quaterniond q_imu_cam(rig_.T_imu_cam.linear());
    const Eigen::Quaterniond q_previous_current = q_imu_cam.conjugate() * turn_imu->q * q_imu_cam;
    return KnownRotation{q_previous_current.conjugate(), turn_imu->sigma_rad};
}

Eigen::Isometry3d Motion::expect(const std::optional<KnownRotation>& turn,
                                 std::int64_t timestamp_ns) const {
    const double interval_s =
        std::min(seconds(timestamp_ns - timestamp_ns_), kLongestExtrapolation_s);
    Eigen::Isometry3d T_previous_current = Eigen::Isometry3d::Identity();
    T_previous_current.linear() =
        (turn ? turn->q.conjugate() : rotation_from_vector(turn_rate_cam_ * interval_s))
            .toRotationMatrix();
    T_previous_current.translation() = velocity_cam_ * interval_s;
    return T_previous_current.inverse();
}

void Motion::advance(const Eigen::Isometry3d& T_current_previous, std::int64_t timestamp_ns) {
    const Eigen::Isometry3d T_previous_current = T_current_previous.inverse();
    const double interval_s = std::max(seconds(timestamp_ns - timestamp_ns_), 1e-6);
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
