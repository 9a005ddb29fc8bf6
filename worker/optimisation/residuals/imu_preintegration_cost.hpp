#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/base/rotation_vector.hpp"
#include "worker/imu/preintegration.hpp"

namespace divemesh::optimisation {

// The IMU between two keyframes i and j, dt apart (Forster et al. 2017, eq. 45), with g =
// kGravity_m_s2 * down:
//
//     e_rotation = log((q_ij exp(J_R (b_g - b_g0)))^-1 q_i^-1 q_j)
//     e_velocity = q_i^-1 (v_j - v_i - g dt) - (dv + J_v (b - b_0))
//     e_position = q_i^-1 (p_j - p_i - v_i dt - g dt^2 / 2) - (dp + J_p (b - b_0))
//     r = L^-1 e,   L L^T = the covariance of the integral
//
// Blocks: q_world_imu (x y z w), p_world_imu, velocity_world, gyroscope and accelerometer bias of
// i; the first three of j; gravity_direction_world (unit vector). The logarithm is that of small
// rotations; its error is far below the noise.
class ImuPreintegrationCost {
public:
    explicit ImuPreintegrationCost(const imu::PreintegratedImu& integral)
        : integral_(integral),
          sqrt_information_(integral.covariance.llt().matrixL().solve(
              imu::PreintegratedImu::Covariance::Identity())) {}

    template <typename T>
    // Ceres passes each block by itself. NOLINTNEXTLINE(readability-function-size)
    bool operator()(const T* const q_i,
                    const T* const p_i,
                    const T* const v_i,
                    const T* const gyroscope_bias,
                    const T* const accelerometer_bias,
                    const T* const q_j,
                    const T* const p_j,
                    const T* const v_j,
                    const T* const gravity_direction_world,
                    T* residual) const {
        using Vector = Eigen::Matrix<T, 3, 1>;
        using ConstVector = Eigen::Map<const Vector>;
        const Eigen::Map<const Eigen::Quaternion<T>> from(q_i);
        const Eigen::Map<const Eigen::Quaternion<T>> to(q_j);
        const double dt = integral_.rotation.duration_s;
        const Vector g = T(imu::kGravity_m_s2) * ConstVector(gravity_direction_world);
        const Vector gyroscope = ConstVector(gyroscope_bias) - integral_.rotation.bias.cast<T>();
        const Vector accelerometer =
            ConstVector(accelerometer_bias) - integral_.accelerometer_bias.cast<T>();

        const Vector correction = integral_.rotation.d_rotation_d_bias.cast<T>() * gyroscope;
        const Eigen::Quaternion<T> rotation = integral_.rotation.q_from_to.cast<T>() *
                                              base::rotation_from_small_vector<T>(correction);
        const Eigen::Quaternion<T> error = rotation.conjugate() * (from.conjugate() * to);
        Eigen::Matrix<T, 9, 1> e;
        e.template head<3>() = base::vector_from_small_rotation(error);
        e.template segment<3>(3) =
            from.conjugate() * Vector(ConstVector(v_j) - ConstVector(v_i) - g * T(dt)) -
            (integral_.delta_velocity.cast<T>() +
             integral_.d_velocity_d_gyroscope.cast<T>() * gyroscope +
             integral_.d_velocity_d_accelerometer.cast<T>() * accelerometer);
        e.template tail<3>() =
            from.conjugate() * Vector(ConstVector(p_j) - ConstVector(p_i) -
                                      ConstVector(v_i) * T(dt) - g * T(0.5 * dt * dt)) -
            (integral_.delta_position.cast<T>() +
             integral_.d_position_d_gyroscope.cast<T>() * gyroscope +
             integral_.d_position_d_accelerometer.cast<T>() * accelerometer);
        Eigen::Map<Eigen::Matrix<T, 9, 1>>(residual).noalias() = sqrt_information_.cast<T>() * e;
        return true;
    }

    static ceres::CostFunction* create(const imu::PreintegratedImu& integral) {
        return new ceres::AutoDiffCostFunction<ImuPreintegrationCost, 9, 4, 3, 3, 3, 3, 4, 3, 3, 3>(
            new ImuPreintegrationCost(integral));
    }

private:
    imu::PreintegratedImu integral_;
    imu::PreintegratedImu::Covariance sqrt_information_;  // L^-1
};

}  // namespace divemesh::optimisation
