#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "tests/synthetic/stereo_world.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/imu/preintegration.hpp"

// The readings of an ideal IMU on a path given as a function of time, T_world_imu(t_s).
namespace divemesh::synthetic {

constexpr double kDerivativeStep_s = 1e-3;

// Returns a pose on the path of stereo_world.hpp, at ten frames per second.
inline Eigen::Isometry3d T_world_imu_at(double t_s) {
    return T_world_cam(10.0 * t_s) * rig().T_imu_cam.inverse();
}

// Returns the velocity in the world, m/s, by central differences.
template <typename Motion>
Eigen::Vector3d velocity(const Motion& T_world_imu, double t_s) {
    const double h = kDerivativeStep_s;
    return (8.0 * (T_world_imu(t_s + h).translation() - T_world_imu(t_s - h).translation()) -
            (T_world_imu(t_s + 2 * h).translation() - T_world_imu(t_s - 2 * h).translation())) /
           (12.0 * h);
}

// Returns the ideal reading at a time, accelerations with gravity.
template <typename Motion>
types::ImuSample imu_at(const Motion& T_world_imu, double t_s) {
    const double h = kDerivativeStep_s;
    const Eigen::Vector3d acceleration =
        (velocity(T_world_imu, t_s + h) - velocity(T_world_imu, t_s - h)) / (2.0 * h);
    const Eigen::Matrix3d R = T_world_imu(t_s).linear();
    const Eigen::Vector3d turn = base::vector_from_rotation(Eigen::Quaterniond(
        T_world_imu(t_s - h).linear().transpose() * T_world_imu(t_s + h).linear()));
    types::ImuSample sample;
    sample.timestamp_ns = std::llround(1e9 * t_s);
    sample.angular_velocity_imu = turn / (2.0 * h);
    sample.acceleration_imu =
        R.transpose() * (acceleration + imu::kGravity_m_s2 * Eigen::Vector3d::UnitZ());
    return sample;
}

// Returns readings from `from_s` to `to_s`, with `bias` added.
template <typename Motion>
std::vector<types::ImuSample> imu_along(const Motion& T_world_imu,
                                        double from_s,
                                        double to_s,
                                        const imu::ImuBias& bias,
                                        double rate_hz = 200.0) {
    std::vector<types::ImuSample> samples;
    const auto num = std::lround((to_s - from_s) * rate_hz);
    for (long i = 0; i <= num; ++i) {
        auto sample = imu_at(T_world_imu, from_s + static_cast<double>(i) / rate_hz);
        sample.angular_velocity_imu += bias.gyroscope;
        sample.acceleration_imu += bias.accelerometer;
        samples.push_back(sample);
    }
    return samples;
}

}  // namespace divemesh::synthetic
