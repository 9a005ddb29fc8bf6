#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/estimation/gyroscope_integral.hpp"

namespace divemesh::worker {

// The turn between two keyframes by the gyroscope, and its bias, which walks:
//
//     r_0..2 = log((q_ij exp(J (b_i - b_0)))^-1 q_i^-1 q_j) / sigma_turn
//     r_3..5 = (b_j - b_i) / sigma_walk
//
// Blocks: q_world_imu of i and j (x y z w), bias of i and j (rad/s). The logarithm is taken as
// twice the vector part: the rest is far below the noise.
struct GyroscopeTurn {
    GyroscopeIntegral integral;
    double sigma_walk = 0.0;  // rad/s

    template <typename T>
    bool operator()(const T* const q_i,
                    const T* const q_j,
                    const T* const bias_i,
                    const T* const bias_j,
                    T* residual) const {
        using Vector = Eigen::Matrix<T, 3, 1>;
        const Eigen::Map<const Eigen::Quaternion<T>> from(q_i);
        const Eigen::Map<const Eigen::Quaternion<T>> to(q_j);
        const Eigen::Map<const Vector> b_i(bias_i);
        const Eigen::Map<const Vector> b_j(bias_j);
        const Vector half =
            T(0.5) * (integral.d_rotation_d_bias.cast<T>() * (b_i - integral.bias.cast<T>()));
        const Eigen::Quaternion<T> correction(T(1.0), half.x(), half.y(), half.z());
        const Eigen::Quaternion<T> turn = integral.q_from_to.cast<T>() * correction.normalized();
        const Eigen::Quaternion<T> error = turn.conjugate() * (from.conjugate() * to);
        const T sign = error.w() < T(0.0) ? T(-2.0) : T(2.0);
        Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residual);
        r.template head<3>() = sign * error.vec() / T(integral.sigma_rad);
        r.template tail<3>() = (b_j - b_i) / T(sigma_walk);
        return true;
    }

    static ceres::CostFunction* create(const GyroscopeTurn& turn) {
        return new ceres::AutoDiffCostFunction<GyroscopeTurn, 6, 4, 4, 3, 3>(
            new GyroscopeTurn(turn));
    }
};

}  // namespace divemesh::worker
