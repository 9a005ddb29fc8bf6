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

struct ImuBias {
    Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();      // rad/s
    Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  // m/s^2
};

// What gyroscope and accelerometer say between two times i and j, whatever pose and velocity the
// body had at i (Forster, Carlone, Dellaert and Scaramuzza, "On-manifold preintegration for
// real-time visual-inertial odometry", 2017):
//
//     turn.q_from_to  = R_i^T R_j
//     delta_velocity = R_i^T (v_j - v_i - g dt)
//     delta_position = R_i^T (p_j - p_i - v_i dt - g dt^2 / 2)
//
// both in imu at i, with derivatives by the biases, so that a change of bias needs no second
// integration, and the covariance of turn (rad, about imu at j), velocity and position, in this
// order, by the white noise of the samples.
struct PreintegratedImu {
    using Covariance = Eigen::Matrix<double, 9, 9>;

    GyroscopeIntegral rotation;
    Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  // m/s^2, that was taken off
    Eigen::Vector3d delta_velocity = Eigen::Vector3d::Zero();      // m/s
    Eigen::Vector3d delta_position = Eigen::Vector3d::Zero();      // m
    Eigen::Matrix3d d_velocity_d_gyroscope = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d d_velocity_d_accelerometer = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d d_position_d_gyroscope = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d d_position_d_accelerometer = Eigen::Matrix3d::Zero();
    Covariance covariance = Covariance::Zero();
};

// Trapezoids over the samples' own intervals, ends interpolated. The covariance takes `noise` as it
// is. Fails where the samples do not cover the interval or leave a gap in it.
std::variant<PreintegratedImu, ImuFailure> preintegrate(
    const std::vector<types::ImuSample>& samples,
    std::int64_t from_ns,
    std::int64_t to_ns,
    const ImuBias& bias,
    const types::ImuNoise& noise);

}  // namespace divemesh::imu
