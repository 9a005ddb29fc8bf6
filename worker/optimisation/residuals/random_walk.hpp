#pragma once

#include <ceres/autodiff_cost_function.h>

namespace divemesh::optimisation {

// The random walk of a vector from one keyframe to the next, such as a sensor's bias:
//
//     r = (x_j - x_i) / sigma
struct RandomWalk {
    double sigma = 0.0;

    template <typename T>
    bool operator()(const T* const x_i, const T* const x_j, T* residual) const {
        for (int i = 0; i < 3; ++i) residual[i] = (x_j[i] - x_i[i]) / T(sigma);
        return true;
    }

    static ceres::CostFunction* create(double sigma) {
        return new ceres::AutoDiffCostFunction<RandomWalk, 3, 3, 3>(new RandomWalk{sigma});
    }
};

}  // namespace divemesh::optimisation
