#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::optimisation {

// An orientation of the body measured by a sensor (AHRS) in its own world, with sigma per axis:
//
//     r = log(q_ahrs_imu^-1 q_world_ahrs^-1 q_world_imu) / sigma
//
// Blocks: q_world_ahrs, q_world_imu (x y z w). The logarithm is that of small rotations.
struct OrientationPrior {
    Eigen::Quaterniond q_ahrs_imu;
    double sigma_rad = 0.0;

    template <typename T>
    bool operator()(const T* const q_world_ahrs, const T* const q_world_imu, T* residual) const {
        const Eigen::Map<const Eigen::Quaternion<T>> world(q_world_ahrs);
        const Eigen::Map<const Eigen::Quaternion<T>> q(q_world_imu);
        const Eigen::Quaternion<T> error =
            q_ahrs_imu.conjugate().cast<T>() * (world.conjugate() * q);
        Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residual);
        r = base::vector_from_small_rotation(error) / T(sigma_rad);
        return true;
    }

    static ceres::CostFunction* create(const OrientationPrior& known) {
        return new ceres::AutoDiffCostFunction<OrientationPrior, 3, 4, 4>(
            new OrientationPrior(known));
    }
};

}  // namespace divemesh::optimisation
