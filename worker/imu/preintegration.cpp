#include "worker/imu/preintegration.hpp"

#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"

namespace divemesh::imu {
namespace {

using Matrix9 = PreintegratedImu::Covariance;
using Matrix93 = Eigen::Matrix<double, 9, 3>;

// One interval between two samples, with the biases subtracted.
struct Step {
    double dt_s = 0.0;
    Eigen::Vector3d rate;                // rad/s, mean of both ends
    Eigen::Vector3d acceleration_begin;  // m/s^2, in the imu frame at each end
    Eigen::Vector3d acceleration_end;
};

// Derivatives of a step's rotation and mean acceleration (in imu at i) with respect to the state
// before it and the step's own noise. `force` is -R [a], the derivative of the acceleration with
// respect to a rotation of its frame.
struct StepDerivatives {
    Eigen::Matrix3d rotation_rotation;  // of the rotation after by the one before
    Eigen::Matrix3d angular_velocity;   // of the rotation after by the rate
    Eigen::Matrix3d force_rotation;
    Eigen::Matrix3d force_rate;
    Eigen::Matrix3d force_acceleration;
};

StepDerivatives derivatives(const Step& step,
                            const Eigen::Matrix3d& R_begin,
                            const Eigen::Matrix3d& R_end) {
    const Eigen::Matrix3d force_begin = -R_begin * base::cross_matrix(step.acceleration_begin);
    const Eigen::Matrix3d force_end = -R_end * base::cross_matrix(step.acceleration_end);
    StepDerivatives d;
    d.rotation_rotation = R_end.transpose() * R_begin;
    d.angular_velocity = base::right_jacobian(step.rate * step.dt_s) * step.dt_s;
    d.force_rotation = 0.5 * (force_begin + force_end * d.rotation_rotation);
    d.force_rate = 0.5 * force_end * d.angular_velocity;
    d.force_acceleration = 0.5 * (R_begin + R_end);
    return d;
}

void propagate_covariance(const StepDerivatives& d,
                          double dt_s,
                          const types::ImuNoise& noise,
                          Matrix9& covariance) {
    const double half_squared = 0.5 * dt_s * dt_s;
    Matrix9 transition = Matrix9::Identity();
    transition.block<3, 3>(0, 0) = d.rotation_rotation;
    transition.block<3, 3>(3, 0) = d.force_rotation * dt_s;
    transition.block<3, 3>(6, 0) = d.force_rotation * half_squared;
    transition.block<3, 3>(6, 3).diagonal().setConstant(dt_s);
    Matrix93 by_rate;
    by_rate << d.angular_velocity, d.force_rate * dt_s, d.force_rate * half_squared;
    Matrix93 by_acceleration;
    by_acceleration << Eigen::Matrix3d::Zero(), d.force_acceleration * dt_s,
        d.force_acceleration * half_squared;
    const double rate_variance =
        noise.gyroscope_noise_density * noise.gyroscope_noise_density / dt_s;
    const double acceleration_variance =
        noise.accelerometer_noise_density * noise.accelerometer_noise_density / dt_s;
    covariance = transition * covariance * transition.transpose() +
                 rate_variance * by_rate * by_rate.transpose() +
                 acceleration_variance * by_acceleration * by_acceleration.transpose();
    // Noise within the step moves the position by s^2 dt^3 / 3, a twelfth of it without changing
    // the velocity. Without this part a single step would tie the two exactly.
    covariance.block<3, 3>(6, 6).diagonal().array() +=
        acceleration_variance * half_squared * half_squared / 3.0;
}

void add_step(const Step& step, const types::ImuNoise& noise, PreintegratedImu& sum) {
    const double dt = step.dt_s;
    GyroscopeIntegral& rotation = sum.rotation;
    const Eigen::Matrix3d R_begin = rotation.q_from_to.toRotationMatrix();
    rotation.q_from_to =
        (rotation.q_from_to * base::rotation_from_vector(step.rate * dt)).normalized();
    const Eigen::Matrix3d R_end = rotation.q_from_to.toRotationMatrix();
    const StepDerivatives d = derivatives(step, R_begin, R_end);

    const Eigen::Matrix3d force_gyroscope =
        d.force_rotation * rotation.d_rotation_d_bias - d.force_rate;
    sum.d_position_d_gyroscope += sum.d_velocity_d_gyroscope * dt + 0.5 * force_gyroscope * dt * dt;
    sum.d_velocity_d_gyroscope += force_gyroscope * dt;
    sum.d_position_d_accelerometer +=
        sum.d_velocity_d_accelerometer * dt - 0.5 * d.force_acceleration * dt * dt;
    sum.d_velocity_d_accelerometer -= d.force_acceleration * dt;
    rotation.d_rotation_d_bias =
        d.rotation_rotation * rotation.d_rotation_d_bias - d.angular_velocity;
    propagate_covariance(d, dt, noise, sum.covariance);

    const Eigen::Vector3d force =
        0.5 * (R_begin * step.acceleration_begin + R_end * step.acceleration_end);
    sum.delta_position += sum.delta_velocity * dt + 0.5 * force * dt * dt;
    sum.delta_velocity += force * dt;
}

}  // namespace

std::variant<PreintegratedImu, ImuFailure> preintegrate(
    const std::vector<types::ImuSample>& samples,
    std::int64_t from_ns,
    std::int64_t to_ns,
    const ImuBias& bias,
    const types::ImuNoise& noise) {
    PreintegratedImu sum;
    sum.rotation.bias = bias.gyroscope;
    sum.accelerometer_bias = bias.accelerometer;
    const auto failure = for_each_step(
        samples,
        from_ns,
        to_ns,
        [&](const types::ImuSample& begin, const types::ImuSample& end, double dt_s) {
            const Eigen::Vector3d rate =
                0.5 * (begin.angular_velocity_imu + end.angular_velocity_imu) - bias.gyroscope;
            add_step({dt_s,
                      rate,
                      begin.acceleration_imu - bias.accelerometer,
                      end.acceleration_imu - bias.accelerometer},
                     noise,
                     sum);
        });
    if (failure) return *failure;
    sum.rotation.duration_s = base::to_s(to_ns - from_ns);
    sum.rotation.sigma_rad = noise.gyroscope_noise_density * std::sqrt(sum.rotation.duration_s);
    return sum;
}

}  // namespace divemesh::imu
