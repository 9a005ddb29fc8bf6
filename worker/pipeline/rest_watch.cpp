#include "worker/pipeline/rest_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/base/seconds.hpp"
#include "worker/odometry/frame_features.hpp"

namespace divemesh::pipeline {
namespace {

// A rig that turns faster than one degree a second does not rest, whatever the images show.
constexpr std::int64_t kTurnTime_ns = 500'000'000;
constexpr double kTurned_rad = 0.01;
constexpr std::int64_t kForceTime_ns = 200'000'000;
constexpr std::int64_t kNumForces = 5;
constexpr double kForceAtRest_m_s2 = 0.02;
constexpr double kMaxForceNoise_m_s2 = 0.1;
constexpr double kNoiseSigmas = 4.0;
constexpr std::int64_t kLately_ns = 2'000'000'000;
// Between two frames. Own gear in view would otherwise hold a rig that glides on evenly.
constexpr double kMaxShiftAtRest_px = 2.0;
constexpr std::int64_t kBiasTime_ns = 7'000'000'000;  // later the sliding window knows it as well

}  // namespace

std::optional<Eigen::Isometry3d> RestWatch::watch(const odometry::Registration& vision,
                                                  const types::Features& features,
                                                  const Eigen::Isometry3d& estimated,
                                                  std::int64_t now_ns) {
    if (rotates_by_gyroscope(now_ns)) {
        detector_.restart();
        return std::nullopt;
    }
    const bool rests = rests_by_imu(now_ns);
    if (!vision.found && !rests) {
        detector_.pass_frame();
        return std::nullopt;
    }
    detector_.join(odometry::previous_static_features(vision));
    using Seen = odometry::RestDetector::Seen;
    const Eigen::Isometry3d T_world_cam = motion_.T_world_cam() * estimated.inverse();
    const auto T_world_rest =
        rests ? detector_.watch(now_ns, features, T_world_cam, Seen::AllFeaturesAtRest)
              : detector_.watch(now_ns, odometry::static_features(vision), T_world_cam);
    if (!T_world_rest) return std::nullopt;
    return T_world_rest->inverse() * motion_.T_world_cam();
}

bool RestWatch::confirmed_by_imu(const odometry::Registration& vision, std::int64_t now_ns) const {
    return detector_.at_rest() && !rotates_by_gyroscope(now_ns) && rests_by_imu(now_ns) &&
           odometry::median_shift_px(vision.inliers) < kMaxShiftAtRest_px;
}

bool RestWatch::rested_lately(std::int64_t now_ns) const {
    return confirmed_ns_ && now_ns - *confirmed_ns_ <= kLately_ns;
}

bool RestWatch::rotates_by_gyroscope(std::int64_t now_ns) const {
    const auto turned = inertial_.rotation(now_ns - kTurnTime_ns, now_ns);
    if (!turned) return false;
    const double angle_rad = Eigen::AngleAxisd(turned->q).angle();
    return angle_rad > kTurned_rad + 3.0 * turned->sigma_rad;
}

// Returns whether the IMU measured the same force for a second. An even glide does so too.
bool RestWatch::rests_by_imu(std::int64_t now_ns) const {
    const double noise_m_s2 =
        inertial_.noise().accelerometer_noise_density / std::sqrt(base::to_s(kForceTime_ns));
    if (!inertial_.has_accelerometer() || kNoiseSigmas * noise_m_s2 > kMaxForceNoise_m_s2)
        return false;
    std::array<Eigen::Vector3d, kNumForces> forces;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::int64_t i = 0; i < kNumForces; ++i) {
        const std::int64_t to_ns = now_ns - i * kForceTime_ns;
        const auto motion = inertial_.motion(to_ns - kForceTime_ns, to_ns);
        if (!motion) return false;
        forces[static_cast<std::size_t>(i)] = motion->delta_velocity / base::to_s(kForceTime_ns);
        mean += forces[static_cast<std::size_t>(i)] / kNumForces;
    }
    return std::ranges::all_of(forces, [&](const Eigen::Vector3d& force) {
        return (force - mean).norm() < kForceAtRest_m_s2 + kNoiseSigmas * noise_m_s2;
    });
}

void RestWatch::settle(std::int64_t now_ns) {
    motion_.rest();
    const std::int64_t began_ns = detector_.began_ns();
    if (rests_.empty() || rests_.back().from_ns != began_ns) rests_.emplace_back();
    rests_.back() = {began_ns, now_ns, detector_.sigma_m(), detector_.sigma_rad()};
    if (rests_by_imu(now_ns)) confirmed_ns_ = now_ns;
    if (now_ns - detector_.began_ns() > kBiasTime_ns) return;
    const Eigen::Quaterniond q_imu_cam(rig_.T_imu_cam.linear());
    inertial_.learn_bias_at_rest(
        detector_.began_ns(), now_ns, q_imu_cam * detector_.q_anchor_cam() * q_imu_cam.conjugate());
}

}  // namespace divemesh::pipeline
