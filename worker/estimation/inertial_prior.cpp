#include "worker/estimation/inertial_prior.hpp"

#include <algorithm>
#include <cmath>

#include "worker/geometry/rotation_vector.hpp"

namespace divemesh::worker {
namespace {

constexpr std::int64_t kLongestAhrsGap_ns = 200'000'000;
constexpr std::int64_t kLevelling_ns = 1'000'000'000;
constexpr double kAhrsTurnSigma_rad = 1e-3;    // white noise of two readings
constexpr double kAhrsDrift_rad_per_s = 3e-3;  // its slow error on the move
constexpr double kVisionTurnSigma_rad = 5e-4;  // of one frame's rotation by vision

}  // namespace

InertialPrior::InertialPrior(const Recording& recording, const ReconstructionOptions& options)
    : recording_(recording),
      gyroscope_(options.use_imu && recording.rig().imu_noise && !recording.imu().empty()),
      ahrs_(options.use_ahrs && !recording.ahrs().empty()),
      noise_(recording.rig().imu_noise.value_or(ImuNoise{})) {}

std::optional<GyroscopeIntegral> InertialPrior::integral(std::int64_t from_ns,
                                                         std::int64_t to_ns) const {
    if (!gyroscope_) return std::nullopt;
    return integrate_gyroscope(recording_.imu(), from_ns, to_ns, bias_, noise_);
}

std::optional<KnownRotation> InertialPrior::turn(std::int64_t from_ns, std::int64_t to_ns) const {
    if (const auto gyroscope = integral(from_ns, to_ns))
        return KnownRotation{gyroscope->q_from_to,
                             std::hypot(gyroscope->sigma_rad, bias_sigma_ * gyroscope->duration_s)};
    const auto from = absolute(from_ns);
    const auto to = absolute(to_ns);
    if (!from || !to) return std::nullopt;
    const double duration_s = 1e-9 * static_cast<double>(to_ns - from_ns);
    return KnownRotation{from->conjugate() * *to,
                         std::hypot(kAhrsTurnSigma_rad, kAhrsDrift_rad_per_s * duration_s)};
}

std::optional<Eigen::Quaterniond> InertialPrior::absolute(std::int64_t time_ns) const {
    if (!ahrs_) return std::nullopt;
    const auto& samples = recording_.ahrs();
    const auto after = std::lower_bound(samples.begin(),
                                        samples.end(),
                                        time_ns,
                                        [](const OrientationSample& sample, std::int64_t time) {
                                            return sample.timestamp_ns < time;
                                        });
    if (after == samples.end()) return std::nullopt;
    if (after->timestamp_ns == time_ns) return after->q_world_imu;
    if (after == samples.begin()) return std::nullopt;
    const auto before = after - 1;
    const std::int64_t gap_ns = after->timestamp_ns - before->timestamp_ns;
    if (gap_ns > kLongestAhrsGap_ns) return std::nullopt;
    return before->q_world_imu.slerp(
        static_cast<double>(time_ns - before->timestamp_ns) / static_cast<double>(gap_ns),
        after->q_world_imu);
}

Eigen::Quaterniond InertialPrior::initial_orientation(std::int64_t time_ns,
                                                      const Eigen::Matrix3d& R_imu_cam) const {
    if (const auto q_world_imu = absolute(time_ns)) return *q_world_imu;
    Eigen::Vector3d up_imu = -R_imu_cam.col(1);  // no inertial sensor: the camera is held level
    if (gyroscope_) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const ImuSample& sample : recording_.imu()) {
            if (sample.timestamp_ns < time_ns) continue;
            if (sample.timestamp_ns > time_ns + kLevelling_ns) break;
            const auto turned = turn(time_ns, sample.timestamp_ns);
            const Eigen::Quaterniond q = turned ? turned->q : Eigen::Quaterniond::Identity();
            sum += q * sample.acceleration_imu;
        }
        if (sum.norm() > 1e-3) up_imu = sum.normalized();
    }
    // Heading: the camera looks along world x, or its upper edge does when it looks up or down.
    Eigen::Vector3d ahead_imu = R_imu_cam.col(2);
    if (std::abs(ahead_imu.dot(up_imu)) > 0.9) ahead_imu = -R_imu_cam.col(1);
    Eigen::Matrix3d R_imu_world;
    R_imu_world.col(2) = up_imu;
    R_imu_world.col(1) = up_imu.cross(ahead_imu).normalized();
    R_imu_world.col(0) = R_imu_world.col(1).cross(up_imu);
    return Eigen::Quaterniond(R_imu_world.transpose());
}

void InertialPrior::learn_bias(std::int64_t from_ns,
                               std::int64_t to_ns,
                               const Eigen::Quaterniond& seen) {
    const auto gyroscope = integral(from_ns, to_ns);
    if (!gyroscope) return;
    const Eigen::Vector3d error =
        vector_from_rotation(seen.conjugate() * gyroscope->q_from_to) / gyroscope->duration_s;
    // A scalar Kalman filter per axis; the bias walks.
    const double walked = noise_.gyroscope_random_walk * std::sqrt(gyroscope->duration_s);
    const double variance = bias_sigma_ * bias_sigma_ + walked * walked;
    const double measured =
        std::hypot(kVisionTurnSigma_rad, gyroscope->sigma_rad) / gyroscope->duration_s;
    const double gain = variance / (variance + measured * measured);
    // One wild frame must not throw it off.
    const double limit = 3.0 * std::sqrt(variance + measured * measured);
    bias_ += gain * error.cwiseMax(-limit).cwiseMin(limit);
    bias_sigma_ = std::sqrt((1.0 - gain) * variance);
}

void InertialPrior::set_bias(const Eigen::Vector3d& bias, double sigma) {
    bias_ = bias;
    bias_sigma_ = sigma;
}

}  // namespace divemesh::worker
