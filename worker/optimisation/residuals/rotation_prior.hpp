#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

namespace divemesh::optimisation {

// A rotation known from another sensor (IMU, AHRS), with sigma per axis:
//
//     r = log(q_known^-1 * exp(w)) / sigma        w: Rodrigues vector [rad]
struct RotationPrior {
    Eigen::Quaterniond q_known;
    double sigma_rad = 0.0;

    template <typename T>
    bool operator()(const T* const rodrigues, T* residual) const {
        T q[4];
        ceres::AngleAxisToQuaternion(rodrigues, q);
        const T known_inverse[4] = {
            T(q_known.w()), T(-q_known.x()), T(-q_known.y()), T(-q_known.z())};
        T difference[4];
        ceres::QuaternionProduct(known_inverse, q, difference);
        ceres::QuaternionToAngleAxis(difference, residual);
        for (int i = 0; i < 3; ++i) residual[i] /= T(sigma_rad);
        return true;
    }

    static ceres::CostFunction* create(const Eigen::Quaterniond& q_known, double sigma_rad) {
        return new ceres::AutoDiffCostFunction<RotationPrior, 3, 3>(
            new RotationPrior{q_known, sigma_rad});
    }
};

}  // namespace divemesh::optimisation
