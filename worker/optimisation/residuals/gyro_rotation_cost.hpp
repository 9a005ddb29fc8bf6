#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/base/rotation_vector.hpp"
#include "worker/imu/gyroscope_integral.hpp"

namespace divemesh::optimisation {

// The gyroscope's rotation between two keyframes:
//
//     r = log((q_ij exp(J (b_i - b_0)))^-1 q_i^-1 q_j) / sigma_rotation
//
// Blocks: q_world_imu of i and j (x y z w), bias of i (rad/s). The logarithm is that of small
// rotations; its error is far below the noise.
struct GyroRotationCost {
    imu::GyroscopeIntegral integral;

    template <typename T>
    bool operator()(const T* const q_i,
                    const T* const q_j,
                    const T* const bias_i,
                    T* residual) const {
        using Vector = Eigen::Matrix<T, 3, 1>;
        const Eigen::Map<const Eigen::Quaternion<T>> from(q_i);
        const Eigen::Map<const Eigen::Quaternion<T>> to(q_j);
        const Eigen::Map<const Vector> bias(bias_i);
        const Vector correction =
            integral.d_rotation_d_bias.cast<T>() * (bias - integral.bias.cast<T>());
        const Eigen::Quaternion<T> rotation =
            integral.q_from_to.cast<T>() * base::rotation_from_small_vector<T>(correction);
        const Eigen::Quaternion<T> error = rotation.conjugate() * (from.conjugate() * to);
        Eigen::Map<Vector> r(residual);
        r = base::vector_from_small_rotation(error) / T(integral.sigma_rad);
        return true;
    }

    static ceres::CostFunction* create(const imu::GyroscopeIntegral& integral) {
        return new ceres::AutoDiffCostFunction<GyroRotationCost, 3, 4, 4, 3>(
            new GyroRotationCost{integral});
    }
};

}  // namespace divemesh::optimisation
