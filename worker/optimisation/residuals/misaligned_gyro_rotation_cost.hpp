#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/base/rotation_vector.hpp"
#include "worker/imu/gyroscope_integral.hpp"

namespace divemesh::optimisation {

// The rotation between two keyframes from a gyroscope with misalignment m, time offset dt and rates
// that are too large by the shares e:
//
//     r = log((M q_ij exp(J_b (b_i - b_0) + J_t (dt - dt_0) - diag(log q_ij) e) M^-1)^-1
//             q_i^-1 q_j) / sigma
//
// M = exp(m) maps imu to body; q_ij was integrated at dt_0, and J_t = w_j - q_ij^-1 w_i is the
// difference of the rates at its two ends. Blocks: q_world_body of i and j (x y z w), bias of i
// (rad/s, imu), m (rad), dt (s), e (axes of imu). Logarithms are those of small rotations; m stays
// within a few degrees.
struct MisalignedGyroRotationCost {
    imu::GyroscopeIntegral integral;
    Eigen::Vector3d d_rotation_d_time = Eigen::Vector3d::Zero();  // rad/s
    double time_offset_s = 0.0;                                   // dt_0

    template <typename T>
    bool operator()(const T* const q_i,
                    const T* const q_j,
                    const T* const bias_i,
                    const T* const misalignment,
                    const T* const time_offset,
                    const T* const rate_error,
                    T* residual) const {
        using Vector = Eigen::Matrix<T, 3, 1>;
        using Quaternion = Eigen::Quaternion<T>;
        const Eigen::Map<const Quaternion> from(q_i);
        const Eigen::Map<const Quaternion> to(q_j);
        const Eigen::Map<const Vector> bias(bias_i);
        const Eigen::Map<const Vector> m(misalignment);
        const Eigen::Map<const Vector> too_large(rate_error);
        const Vector turned = base::vector_from_rotation(integral.q_from_to).cast<T>();
        const Vector change =
            integral.d_rotation_d_bias.cast<T>() * (bias - integral.bias.cast<T>()) +
            d_rotation_d_time.cast<T>() * (time_offset[0] - T(time_offset_s)) -
            turned.cwiseProduct(too_large);
        const Quaternion rotation_imu =
            integral.q_from_to.cast<T>() * base::rotation_from_small_vector<T>(change);
        const Quaternion M = base::rotation_from_small_vector<T>(m);
        const Quaternion rotation = M * rotation_imu * M.conjugate();
        const Quaternion error = rotation.conjugate() * (from.conjugate() * to);
        Eigen::Map<Vector> r(residual);
        r = base::vector_from_small_rotation(error) / T(integral.sigma_rad);
        return true;
    }

    static ceres::CostFunction* create(const MisalignedGyroRotationCost& rotation) {
        return new ceres::AutoDiffCostFunction<MisalignedGyroRotationCost, 3, 4, 4, 3, 3, 1, 3>(
            new MisalignedGyroRotationCost(rotation));
    }
};

}  // namespace divemesh::optimisation
