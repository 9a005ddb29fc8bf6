#pragma once

#include <Eigen/Core>
#include <ceres/autodiff_cost_function.h>

namespace divemesh::optimisation {

// A vector known in advance with sigma per axis, such as a gyroscope's bias:
//
//     r = (x - x_known) / sigma
struct VectorPrior {
    Eigen::Vector3d known;
    double sigma = 0.0;

    template <typename T>
    bool operator()(const T* const x, T* residual) const {
        for (int i = 0; i < 3; ++i) residual[i] = (x[i] - T(known[i])) / T(sigma);
        return true;
    }

    static ceres::CostFunction* create(const VectorPrior& prior) {
        return new ceres::AutoDiffCostFunction<VectorPrior, 3, 3>(new VectorPrior(prior));
    }
};

}  // namespace divemesh::optimisation
