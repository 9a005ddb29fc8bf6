#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::optimisation {

// The relative pose of two poses, known with sigma per axis:
//
//     r_0..2 = (R_a^T (p_b - p_a) - p_known) / sigma_m
//     r_3..5 = log(q_known^-1 q_a^-1 q_b) / sigma_rad
//
// Blocks: q_world (x y z w) and p_world (m) of a, then of b. The logarithm is that of small
// rotations.
struct RelativePose {
    Eigen::Quaterniond q_a_b;
    Eigen::Vector3d p_a_b;
    double sigma_m = 0.0;
    double sigma_rad = 0.0;

    template <typename T>
    bool operator()(const T* const q_world_a,
                    const T* const p_world_a,
                    const T* const q_world_b,
                    const T* const p_world_b,
                    T* residual) const {
        using Vector = Eigen::Matrix<T, 3, 1>;
        const Eigen::Map<const Eigen::Quaternion<T>> q_a(q_world_a);
        const Eigen::Map<const Eigen::Quaternion<T>> q_b(q_world_b);
        const Eigen::Map<const Vector> p_a(p_world_a);
        const Eigen::Map<const Vector> p_b(p_world_b);
        const Eigen::Quaternion<T> error = q_a_b.conjugate().cast<T>() * (q_a.conjugate() * q_b);
        Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residual);
        r.template head<3>() = (q_a.conjugate() * (p_b - p_a) - p_a_b.cast<T>()) / T(sigma_m);
        r.template tail<3>() = base::vector_from_small_rotation(error) / T(sigma_rad);
        return true;
    }

    static ceres::CostFunction* create(const Eigen::Isometry3d& T_a_b,
                                       double sigma_m,
                                       double sigma_rad) {
        return new ceres::AutoDiffCostFunction<RelativePose, 6, 4, 3, 4, 3>(
            new RelativePose{Eigen::Quaterniond(T_a_b.linear()).normalized(),
                             T_a_b.translation(),
                             sigma_m,
                             sigma_rad});
    }
};

}  // namespace divemesh::optimisation
