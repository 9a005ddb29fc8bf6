#include "worker/pipeline/rest_watch.hpp"

#include "worker/odometry/frame_features.hpp"

namespace divemesh::pipeline {
namespace {

// A rig that turns faster than one degree a second does not rest, whatever the images show.
constexpr std::int64_t kTurnTime_ns = 500'000'000;
constexpr double kTurned_rad = 0.01;
constexpr std::int64_t kBiasTime_ns = 7'000'000'000;  // later the sliding window knows it as well

}  // namespace

std::optional<Eigen::Isometry3d> RestWatch::watch(const odometry::Registration& vision,
                                                  const Eigen::Isometry3d& estimated,
                                                  std::int64_t now_ns) {
    if (!vision.found) return std::nullopt;
    if (rotates_by_gyroscope(now_ns)) {
        detector_.restart();
        return std::nullopt;
    }
    const auto T_world_rest = detector_.watch(
        now_ns, odometry::static_features(vision), motion_.T_world_cam() * estimated.inverse());
    if (!T_world_rest) return std::nullopt;
    return T_world_rest->inverse() * motion_.T_world_cam();
}

bool RestWatch::rotates_by_gyroscope(std::int64_t now_ns) const {
    const auto turned = inertial_.rotation(now_ns - kTurnTime_ns, now_ns);
    if (!turned) return false;
    const double angle_rad = Eigen::AngleAxisd(turned->q).angle();
    return angle_rad > kTurned_rad + 3.0 * turned->sigma_rad;
}

void RestWatch::settle(std::int64_t now_ns) {
    motion_.rest();
    const std::int64_t began_ns = detector_.began_ns();
    if (rests_.empty() || rests_.back().from_ns != began_ns) rests_.emplace_back();
    rests_.back() = {began_ns, now_ns, detector_.sigma_m(), detector_.sigma_rad()};
    if (now_ns - detector_.began_ns() > kBiasTime_ns) return;
    const Eigen::Quaterniond q_imu_cam(rig_.T_imu_cam.linear());
    inertial_.learn_bias_at_rest(
        detector_.began_ns(), now_ns, q_imu_cam * detector_.q_anchor_cam() * q_imu_cam.conjugate());
}

}  // namespace divemesh::pipeline
