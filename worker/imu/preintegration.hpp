#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <variant>
#include <vector>

#include "worker/imu/gyroscope_integral.hpp"
#include "worker/imu/imu_steps.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::imu {

constexpr double kGravity_m_s2 = 9.81;

// The biases of the IMU, in the imu frame.
struct ImuBias {
    Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();      // rad/s
    Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  // m/s^2
};

// The motion between two times i and j from gyroscope and accelerometer, independent of the pose
// and velocity at i (Forster, Carlone, Dellaert and Scaramuzza, "On-manifold preintegration for
// real-time visual-inertial odometry", 2017):
//
//     rotation.q_from_to = R_i^T R_j
//     delta_velocity     = R_i^T (v_j - v_i - g dt)
//     delta_position     = R_i^T (p_j - p_i - v_i dt - g dt^2 / 2)
//
// both in imu at i. Their derivatives with respect to the biases avoid a second integration when a
// bias changes. The covariance is of rotation (rad, about imu at j), velocity and position, in this
// order, from the samples' white noise.
struct PreintegratedImu {
    using Covariance = Eigen::Matrix<double, 9, 9>;

    GyroscopeIntegral rotation;
    Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  // m/s^2, already subtracted
    Eigen::Vector3d delta_velocity = Eigen::Vector3d::Zero();      // m/s
    Eigen::Vector3d delta_position = Eigen::Vector3d::Zero();      // m
    Eigen::Matrix3d d_velocity_d_gyroscope = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d d_velocity_d_accelerometer = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d d_position_d_gyroscope = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d d_position_d_accelerometer = Eigen::Matrix3d::Zero();
    Covariance covariance = Covariance::Zero();
};

// Returns the integral by the trapezoidal rule over the samples' own intervals, with interpolated
// ends. The covariance uses `noise` as given. Returns a failure if the samples do not cover the
// interval or leave a gap in it.
std::variant<PreintegratedImu, ImuFailure> preintegrate(
    const std::vector<types::ImuSample>& samples,
    std::int64_t from_ns,
    std::int64_t to_ns,
    const ImuBias& bias,
    const types::ImuNoise& noise);

}  // namespace divemesh::imu
