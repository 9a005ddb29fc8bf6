#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "worker/base/seconds.hpp"
#include "worker/types/recording.hpp"

// The motion of a diver who sways and turns, with its derivatives written down.
namespace divemesh::evaluation {

constexpr double kDuration_s = 60.0;

inline Eigen::Vector3d position(double t) {
    return {0.3 * t + 0.1 * std::sin(2.1 * t), 0.15 * std::sin(1.3 * t), 0.8 * std::sin(0.4 * t)};
}
inline Eigen::Vector3d acceleration(double t) {
    return {-0.1 * 2.1 * 2.1 * std::sin(2.1 * t),
            -0.15 * 1.3 * 1.3 * std::sin(1.3 * t),
            -0.8 * 0.4 * 0.4 * std::sin(0.4 * t)};
}
inline Eigen::Matrix3d orientation(double t) {
    return (Eigen::AngleAxisd(0.3 * std::sin(0.5 * t), Eigen::Vector3d::UnitX()) *
            Eigen::AngleAxisd(0.2 * t, Eigen::Vector3d::UnitZ()))
        .toRotationMatrix();
}
inline Eigen::Vector3d rate_imu(double t) {
    const Eigen::AngleAxisd heading(0.2 * t, Eigen::Vector3d::UnitZ());
    return heading.inverse() * Eigen::Vector3d(0.3 * 0.5 * std::cos(0.5 * t), 0.0, 0.0) +
           Eigen::Vector3d(0.0, 0.0, 0.2);
}

// Returns the second derivative of the orientation.
inline Eigen::Matrix3d turning(double t) {
    constexpr double kStep_s = 1e-3;
    return (orientation(t + kStep_s) - 2.0 * orientation(t) + orientation(t - kStep_s)) /
           (kStep_s * kStep_s);
}

// Returns the path by cameras that measure every length `shrunk` times as long as it is.
inline types::Trajectory path_seen(double shrunk,
                                   double duration_s = kDuration_s,
                                   double interval_s = 0.1) {
    types::Trajectory trajectory;
    for (int i = 0; i <= std::lround(duration_s / interval_s); ++i) {
        types::StampedPose pose{base::to_ns(interval_s * i), Eigen::Isometry3d::Identity()};
        pose.T_world_imu.linear() = orientation(interval_s * i);
        pose.T_world_imu.translation() = shrunk * position(interval_s * i);
        trajectory.push_back(pose);
    }
    return trajectory;
}

// Returns what an IMU feels at a place on the body: `lever_arm_m` away from the origin.
inline std::vector<types::ImuSample> imu_felt(
    double noise_m_s2,
    std::uint32_t seed,
    const Eigen::Vector3d& lever_arm_m = Eigen::Vector3d::Zero()) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, noise_m_s2);
    std::vector<types::ImuSample> imu;
    for (int i = 0; i <= 200 * static_cast<int>(kDuration_s); ++i) {
        const double t = 0.005 * i;
        types::ImuSample sample;
        sample.timestamp_ns = i * std::int64_t{5'000'000};
        sample.angular_velocity_imu = rate_imu(t) + Eigen::Vector3d(0.01, -0.02, 0.01);
        sample.acceleration_imu =
            orientation(t).transpose() *
                (acceleration(t) + turning(t) * lever_arm_m + Eigen::Vector3d(0.0, 0.0, 9.81)) +
            Eigen::Vector3d(0.05, -0.03, 0.08) +
            Eigen::Vector3d(noise(random), noise(random), noise(random));
        imu.push_back(sample);
    }
    return imu;
}

}  // namespace divemesh::evaluation
