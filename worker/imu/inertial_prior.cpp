#include "worker/imu/inertial_prior.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/imu/measured_noise.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

constexpr std::int64_t kMaxAhrsGap_ns = 200'000'000;
constexpr std::int64_t kMaxPressureGap_ns = 1'000'000'000;
constexpr std::int64_t kGravityAlignment_ns = 1'000'000'000;
constexpr double kAhrsRotationSigma_rad = 1e-3;  // white noise of two samples
constexpr double kAhrsDrift_rad_per_s = 3e-3;    // its slow error in motion
// With a larger error in gravity the accelerometer is not used.
constexpr double kWrongGravity_m_s2 = 0.6;
constexpr double kVisionRotationSigma_rad = 5e-4;  // of one frame's rotation from vision

constexpr double kDepthTimeConstant_s = 2.5;  // of waves and of a slow sensor
constexpr double kUsualDepthChange_m = 0.03;  // the error of a change, by kUsualDepthSigma_m

// Over longer intervals the error of the bias, and of the vertical with it, is no longer small.
constexpr std::int64_t kMaxIntegration_ns = 8'000'000'000;

// The two samples around a time, at most `max_interval_ns` apart.
template <typename Sample>
struct Bracket {
    const Sample* before;
    const Sample* after;
    double share;  // 0 at before, 1 at after
};

template <typename Sample>
std::optional<Bracket<Sample>> bracket(const std::vector<Sample>& samples,
                                       std::int64_t time_ns,
                                       std::int64_t max_interval_ns) {
    const auto after = std::lower_bound(
        samples.begin(), samples.end(), time_ns, [](const Sample& sample, std::int64_t time) {
            return sample.timestamp_ns < time;
        });
    if (after == samples.end()) return std::nullopt;
    if (after->timestamp_ns == time_ns) return Bracket<Sample>{&*after, &*after, 0.0};
    if (after == samples.begin()) return std::nullopt;
    const auto before = after - 1;
    const std::int64_t gap_ns = after->timestamp_ns - before->timestamp_ns;
    if (gap_ns > max_interval_ns) return std::nullopt;
    return Bracket<Sample>{
        &*before,
        &*after,
        static_cast<double>(time_ns - before->timestamp_ns) / static_cast<double>(gap_ns)};
}

// Returns true if the median specific force is close to gravity, as it is on a diver most of the
// time.
bool measures_gravity(const std::vector<types::ImuSample>& samples) {
    if (samples.empty()) return false;
    std::vector<double> forces;
    forces.reserve(samples.size());
    for (const types::ImuSample& sample : samples) forces.push_back(sample.acceleration_imu.norm());
    return std::abs(stats::upper_median(std::move(forces)) - kGravity_m_s2) < kWrongGravity_m_s2;
}

}  // namespace

InertialPrior::InertialPrior(const types::Recording& recording,
                             const ReconstructionOptions& options,
                             const types::SensorsLeftOut& left_out)
    : recording_(recording),
      rates_(usable_rates(recording, left_out)),
      imu_(rates_),
      usable_orientations_(usable_orientations(recording, left_out)),
      orientations_(usable_orientations_),
      gyroscope_(options.use_imu && recording.rig().imu_noise && !imu_.empty()),
      accelerometer_(gyroscope_ && !left_out.accelerometer && measures_gravity(imu_)),
      ahrs_(options.use_ahrs && !orientations_.empty()),
      pressure_(options.use_pressure && !left_out.pressure && !recording.pressure().empty()),
      noise_(at_least_measured(
          imu_, on_a_diver(recording.rig().imu_noise.value_or(types::ImuNoise{})))) {}

void InertialPrior::align(const types::ImuAlignment& alignment) {
    imu_ = aligned(rates_, alignment);
    orientations_ = aligned(usable_orientations_, alignment);
}

bool InertialPrior::imu_is_used(std::int64_t from_ns, std::int64_t to_ns) const {
    if (to_ns - from_ns > kMaxIntegration_ns || (imu_ends_ns_ && to_ns >= *imu_ends_ns_))
        return false;
    const auto later =
        std::ranges::upper_bound(contradicted_, from_ns, {}, &types::TimeInterval::to_ns);
    return later == contradicted_.end() || later->from_ns >= to_ns;
}

std::optional<GyroscopeIntegral> InertialPrior::integral(std::int64_t from_ns,
                                                         std::int64_t to_ns) const {
    if (!gyroscope_ || !imu_is_used(from_ns, to_ns)) return std::nullopt;
    return integrate_gyroscope(imu_, from_ns, to_ns, bias_.gyroscope, noise_);
}

std::optional<PreintegratedImu> InertialPrior::motion(std::int64_t from_ns,
                                                      std::int64_t to_ns) const {
    if (!accelerometer_ || !imu_is_used(from_ns, to_ns)) return std::nullopt;
    const auto result = preintegrate(imu_, from_ns, to_ns, bias_, noise_);
    const auto* motion = std::get_if<PreintegratedImu>(&result);
    return motion ? std::optional(*motion) : std::nullopt;
}

std::optional<types::KnownRotation> InertialPrior::rotation_from(
    const Eigen::Quaterniond& q_world_imu, std::int64_t from_ns, std::int64_t to_ns) const {
    if (ahrs_leads_)
        if (const auto q_world_next = absolute(to_ns))
            return types::KnownRotation{q_world_imu.conjugate() * *q_world_next,
                                        kAhrsRotationSigma_rad};
    return rotation(from_ns, to_ns);
}

std::optional<types::KnownRotation> InertialPrior::rotation(std::int64_t from_ns,
                                                            std::int64_t to_ns) const {
    if (const auto gyroscope = integral(from_ns, to_ns))
        return types::KnownRotation{
            gyroscope->q_from_to,
            std::hypot(gyroscope->sigma_rad, bias_sigma_ * gyroscope->duration_s)};
    const auto from = absolute(from_ns);
    const auto to = absolute(to_ns);
    if (!from || !to) return std::nullopt;
    const double duration_s = base::to_s(to_ns - from_ns);
    return types::KnownRotation{
        from->conjugate() * *to,
        std::hypot(kAhrsRotationSigma_rad, kAhrsDrift_rad_per_s * duration_s)};
}

std::optional<Eigen::Quaterniond> InertialPrior::absolute(std::int64_t time_ns) const {
    if (!ahrs_) return std::nullopt;
    const auto around = bracket(orientations_, time_ns, kMaxAhrsGap_ns);
    if (!around) return std::nullopt;
    return around->before->q_world_imu.slerp(around->share, around->after->q_world_imu);
}

std::optional<double> InertialPrior::depth_m(std::int64_t time_ns) const {
    if (!pressure_) return std::nullopt;
    const auto around = bracket(recording_.pressure(), time_ns, kMaxPressureGap_ns);
    if (!around) return std::nullopt;
    return around->before->depth_m +
           around->share * (around->after->depth_m - around->before->depth_m);
}

// A Gauss-Markov error is represented by white noise whose variance is multiplied by twice its time
// constant over the interval.
double InertialPrior::depth_sigma_m(double interval_s) const {
    if (pressure_error_m_ <= kUsualDepthChange_m) return kUsualDepthSigma_m;
    const double times = 2.0 * kDepthTimeConstant_s / std::max(0.1, interval_s);
    return std::hypot(kUsualDepthSigma_m,
                      pressure_error_m_ / std::numbers::sqrt2 * std::sqrt(std::max(1.0, times)));
}

bool InertialPrior::knows_vertical(std::int64_t time_ns) const {
    return absolute(time_ns) || measured_up(time_ns);
}

SensorReadings InertialPrior::readings(std::int64_t from_ns, std::int64_t to_ns) const {
    SensorReadings readings;
    readings.interval_s = base::to_s(to_ns - from_ns);
    readings.motion = motion(from_ns, to_ns);
    if (!readings.motion) readings.rotation = integral(from_ns, to_ns);
    readings.q_ahrs_imu = absolute(to_ns);
    readings.depth_m = depth_m(to_ns);
    readings.depth_sigma_m = depth_sigma_m(readings.interval_s);
    return readings;
}

std::optional<Eigen::Vector3d> InertialPrior::measured_up(std::int64_t time_ns) const {
    if (!accelerometer_) return std::nullopt;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const auto first = std::ranges::lower_bound(imu_, time_ns, {}, &types::ImuSample::timestamp_ns);
    for (auto sample = first; sample != imu_.end(); ++sample) {
        if (sample->timestamp_ns > time_ns + kGravityAlignment_ns) break;
        const auto turned = rotation(time_ns, sample->timestamp_ns);
        const Eigen::Quaterniond q = turned ? turned->q : Eigen::Quaterniond::Identity();
        sum += q * sample->acceleration_imu;
    }
    if (sum.norm() <= 1e-3) return std::nullopt;
    return sum.normalized();
}

Eigen::Quaterniond InertialPrior::initial_orientation(std::int64_t time_ns,
                                                      const Eigen::Matrix3d& R_imu_cam) const {
    if (const auto q_world_imu = absolute(time_ns)) return *q_world_imu;
    const Eigen::Vector3d level = -R_imu_cam.col(1);
    const Eigen::Vector3d up_imu = measured_up(time_ns).value_or(level);
    // Heading: the camera looks along world x; if it looks up or down, its upper edge points along
    // x.
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
        base::vector_from_rotation(seen.conjugate() * gyroscope->q_from_to) / gyroscope->duration_s;
    // A scalar Kalman filter per axis; the bias is a random walk.
    const double walked = noise_.gyroscope_random_walk * std::sqrt(gyroscope->duration_s);
    const double variance = bias_sigma_ * bias_sigma_ + walked * walked;
    const double measured =
        std::hypot(kVisionRotationSigma_rad, gyroscope->sigma_rad) / gyroscope->duration_s;
    const double gain = variance / (variance + measured * measured);
    // Limits the effect of a single outlier frame.
    const double limit = 3.0 * std::sqrt(variance + measured * measured);
    bias_.gyroscope += gain * error.cwiseMax(-limit).cwiseMin(limit);
    bias_sigma_ = std::sqrt((1.0 - gain) * variance);
}

void InertialPrior::learn_bias_at_rest(std::int64_t from_ns,
                                       std::int64_t to_ns,
                                       const Eigen::Quaterniond& seen) {
    const auto gyroscope = integral(from_ns, to_ns);
    if (!gyroscope) return;
    bias_.gyroscope +=
        base::vector_from_rotation(seen.conjugate() * gyroscope->q_from_to) / gyroscope->duration_s;
    bias_sigma_ =
        std::hypot(gyroscope->sigma_rad, kVisionRotationSigma_rad) / gyroscope->duration_s;
}

void InertialPrior::set_bias(const ImuBias& bias, double gyroscope_sigma) {
    bias_ = bias;
    bias_sigma_ = gyroscope_sigma;
}

}  // namespace divemesh::imu
