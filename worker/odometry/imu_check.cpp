#include "worker/odometry/imu_check.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::size_t kMinInliers = 30;
constexpr double kMinShare = 0.7;  // of the pairs
// In dives with an IMU that fits, the errors stay below 0.01 rad/s and 0.03 m/s, or within seven
// sigmas.
constexpr double kMaxSigmas = 10.0;
constexpr double kMaxRateError_rad_s = 0.02;
constexpr double kMaxAxesError_rad = 0.1;  // until the alignment with the cameras is estimated
constexpr double kMaxVelocityError_m_s = 0.1;
constexpr double kNoiseSigmas = 3.0;  // of the velocity after a second of the IMU alone
constexpr double kMaxForceError_m_s2 = 0.5;
constexpr double kMaxShift_px = 3.0;
constexpr std::int64_t kSum_ns = 500'000'000;

bool has_a_say(const Registration& vision) {
    const std::size_t num = vision.inliers.size();
    return vision.found && num >= kMinInliers && stats::ratio(num, vision.num_pairs) >= kMinShare;
}

}  // namespace

bool is_elsewhere(const types::RectifiedRig& rig,
                  const Registration& vision,
                  const Eigen::Isometry3d& T_current_previous) {
    if (vision.inliers.empty()) return false;
    std::vector<double> shifts_px;
    for (const PointPair& pair : vision.inliers) {
        const Eigen::Vector3d expected =
            types::project_px(rig, T_current_previous * pair.p_previous);
        shifts_px.push_back((expected - pair.current_px).head<2>().norm());
    }
    return stats::upper_median(std::move(shifts_px)) > kMaxShift_px;
}

bool ImuCheck::contradicts(const Registration& vision,
                           const types::KnownRotation& q_current_previous,
                           const types::TimeInterval& time) {
    if (!steps_.empty() && steps_.back().time.to_ns != time.from_ns) steps_.clear();
    if (!has_a_say(vision)) return false;
    const RefinedPose seen =
        refine_pose(rig_, vision.inliers, {vision.T_current_previous, std::nullopt, 0.0});
    if (seen.outcome.failed()) return false;
    Step step{time,
              base::angle_rad(seen.T_current_previous.linear()),
              base::vector_from_rotation(Eigen::Quaterniond(seen.T_current_previous.linear()) *
                                         q_current_previous.q.conjugate()),
              motion_covariance(rig_, vision.inliers, {seen.T_current_previous, std::nullopt, 0.0})
                  .topLeftCorner<3, 3>()};
    step.covariance.diagonal().array() +=
        q_current_previous.sigma_rad * q_current_previous.sigma_rad;
    steps_.push_back(step);
    while (time.to_ns - steps_.front().time.from_ns > kSum_ns && steps_.size() > 1)
        steps_.pop_front();
    double turned_rad = 0.0;
    Eigen::Vector3d error_rad = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (auto last = steps_.rbegin(); last != steps_.rend(); ++last) {
        turned_rad += last->turned_rad;
        error_rad += last->error_rad;
        covariance += last->covariance;
        const double duration_s = base::to_s(time.to_ns - last->time.from_ns);
        if (error_rad.norm() > kMaxRateError_rad_s * duration_s + kMaxAxesError_rad * turned_rad &&
            error_rad.dot(covariance.ldlt().solve(error_rad)) > kMaxSigmas * kMaxSigmas)
            return true;
    }
    return false;
}

bool ImuCheck::contradicts(const Registration& vision,
                           const Eigen::Isometry3d& T_current_previous,
                           double imu_alone_s,
                           const types::TimeInterval& time) const {
    if (!has_a_say(vision)) return false;
    const double dt_s = base::to_s(time.to_ns - time.from_ns);
    const double error_m = (vision.T_current_previous.inverse().translation() -
                            T_current_previous.inverse().translation())
                               .norm();
    const double velocity_error_m_s = kMaxVelocityError_m_s +
                                      kNoiseSigmas * noise_.accelerometer_noise_density +
                                      kMaxForceError_m_s2 * imu_alone_s;
    if (error_m < velocity_error_m_s * dt_s) return false;
    const double variance_m2 =
        motion_covariance(rig_, vision.inliers, {vision.T_current_previous, std::nullopt, 0.0})
            .bottomRightCorner<3, 3>()
            .trace();
    return error_m > kMaxSigmas * std::sqrt(variance_m2);
}

}  // namespace divemesh::odometry
