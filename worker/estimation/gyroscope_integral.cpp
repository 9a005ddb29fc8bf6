#include "worker/estimation/gyroscope_integral.hpp"

#include <algorithm>
#include <cmath>

#include "worker/geometry/rotation_vector.hpp"

namespace divemesh::worker {
namespace {

constexpr std::int64_t kLongestGap_ns = 100'000'000;
// Data sheets do not know of thrusters and kicks: what they state is taken as so much more.
constexpr double kNoiseInflation = 3.0;

Eigen::Vector3d rate_at(const ImuSample& before, const ImuSample& after, std::int64_t time_ns) {
    const double share = static_cast<double>(time_ns - before.timestamp_ns) /
                         static_cast<double>(after.timestamp_ns - before.timestamp_ns);
    return before.angular_velocity_imu +
           share * (after.angular_velocity_imu - before.angular_velocity_imu);
}

}  // namespace

Eigen::Quaterniond GyroscopeIntegral::rotation(const Eigen::Vector3d& other_bias) const {
    return q_from_to * rotation_from_vector(d_rotation_d_bias * (other_bias - bias));
}

std::optional<GyroscopeIntegral> integrate_gyroscope(const std::vector<ImuSample>& samples,
                                                     std::int64_t from_ns,
                                                     std::int64_t to_ns,
                                                     const Eigen::Vector3d& bias,
                                                     const ImuNoise& noise) {
    if (to_ns <= from_ns || samples.size() < 2 || samples.front().timestamp_ns > from_ns ||
        samples.back().timestamp_ns < to_ns)
        return std::nullopt;
    const auto later = [](std::int64_t time_ns, const ImuSample& sample) {
        return time_ns < sample.timestamp_ns;
    };
    auto after = std::upper_bound(samples.begin(), samples.end(), from_ns, later);
    GyroscopeIntegral integral;
    integral.bias = bias;
    for (std::int64_t time_ns = from_ns; time_ns < to_ns; ++after) {
        if (after == samples.end()) return std::nullopt;
        const ImuSample& before = *(after - 1);
        if (after->timestamp_ns - before.timestamp_ns > kLongestGap_ns) return std::nullopt;
        const std::int64_t end_ns = std::min(after->timestamp_ns, to_ns);
        const double dt = 1e-9 * static_cast<double>(end_ns - time_ns);
        const Eigen::Vector3d rate =
            0.5 * (rate_at(before, *after, time_ns) + rate_at(before, *after, end_ns)) - bias;
        const Eigen::Quaterniond step = rotation_from_vector(rate * dt);
        integral.d_rotation_d_bias =
            step.toRotationMatrix().transpose() * integral.d_rotation_d_bias -
            right_jacobian(rate * dt) * dt;
        integral.q_from_to = (integral.q_from_to * step).normalized();
        time_ns = end_ns;
    }
    integral.duration_s = 1e-9 * static_cast<double>(to_ns - from_ns);
    integral.sigma_rad =
        kNoiseInflation * noise.gyroscope_noise_density * std::sqrt(integral.duration_s);
    return integral;
}

}  // namespace divemesh::worker
