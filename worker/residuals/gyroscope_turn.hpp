#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/estimation/gyroscope_integral.hpp"

namespace divemesh::worker {

// The turn between two keyframes by the gyroscope:
//
//     r = log((q_ij exp(J (b_i - b_0)))^-1 q_i^-1 q_j) / sigma_turn
//
// Blocks: q_world_imu of i and j (x y z w), bias of i (rad/s). The logarithm is taken as twice the
// vector part: the rest is far below the noise.
struct GyroscopeTurn {
    GyroscopeIntegral integral;

    template <typename T>
    bool operator()(const T* const q_i,
                    const T* const q_j,
                    const T* const bias_i,
                    T* residual) const {
        using Vector = Eigen::Matrix<T, 3, 1>;
        const Eigen::Map<const Eigen::Quaternion<T>> from(q_i);
        const Eigen::Map<const Eigen::Quaternion<T>> to(q_j);
        const Eigen::Map<const Vector> bias(bias_i);
        const Vector half =
            T(0.5) * (integral.d_rotation_d_bias.cast<T>() * (bias - integral.bias.cast<T>()));
        const Eigen::Quaternion<T> correction(T(1.0), half.x(), half.y(), half.z());
        const Eigen::Quaternion<T> turn = integral.q_from_to.cast<T>() * correction.normalized();
        const Eigen::Quaternion<T> error = turn.conjugate() * (from.conjugate() * to);
        const T sign = error.w() < T(0.0) ? T(-2.0) : T(2.0);
        Eigen::Map<Vector> r(residual);
        r = sign * error.vec() / T(integral.sigma_rad);
        return true;
    }

    static ceres::CostFunction* create(const GyroscopeIntegral& integral) {
        return new ceres::AutoDiffCostFunction<GyroscopeTurn, 3, 4, 4, 3>(
            new GyroscopeTurn{integral});
    }
};

}  // namespace divemesh::worker
