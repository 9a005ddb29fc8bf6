#include "worker/imu/gyroscope_integral.hpp"

#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/imu/imu_steps.hpp"

namespace divemesh::imu {
namespace {

// Adds one interval between samples, with angular velocity `rate` (rad/s).
void add_step(const Eigen::Vector3d& rate, double dt_s, GyroscopeIntegral& integral) {
    const Eigen::Quaterniond step = base::rotation_from_vector(rate * dt_s);
    integral.d_rotation_d_bias = step.toRotationMatrix().transpose() * integral.d_rotation_d_bias -
                                 base::right_jacobian(rate * dt_s) * dt_s;
    integral.q_from_to = (integral.q_from_to * step).normalized();
}

}  // namespace

Eigen::Quaterniond GyroscopeIntegral::rotation(const Eigen::Vector3d& other_bias) const {
    return q_from_to * base::rotation_from_vector(d_rotation_d_bias * (other_bias - bias));
}

std::optional<GyroscopeIntegral> integrate_gyroscope(const std::vector<types::ImuSample>& samples,
                                                     std::int64_t from_ns,
                                                     std::int64_t to_ns,
                                                     const Eigen::Vector3d& bias,
                                                     const types::ImuNoise& noise) {
    GyroscopeIntegral integral;
    integral.bias = bias;
    const auto failure = for_each_step(
        samples,
        from_ns,
        to_ns,
        [&](const types::ImuSample& begin, const types::ImuSample& end, double dt_s) {
            add_step(0.5 * (begin.angular_velocity_imu + end.angular_velocity_imu) - bias,
                     dt_s,
                     integral);
        });
    if (failure) return std::nullopt;
    integral.duration_s = base::to_s(to_ns - from_ns);
    integral.sigma_rad = noise.gyroscope_noise_density * std::sqrt(integral.duration_s);
    return integral;
}

}  // namespace divemesh::imu
