#pragma once

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <vector>

namespace divemesh::worker {

// What measurements that are kept no longer said about the parameters that are: a Gaussian in
// square-root form,
//
//     r(x) = J (x - at) + r_at          - : the difference of each block's manifold
//
// J stays as it was first estimated, whatever x becomes: what was unobservable then stays so
// (first- estimate Jacobians; Huang, Mourikis and Roumeliotis, "Observability-based rules for
// designing consistent EKF SLAM estimators", 2010). Blocks are known by where their values lie.
struct LinearPrior {
    struct Block {
        double* values = nullptr;
        int tangent_size = 0;
        Eigen::VectorXd at;  // as stored: 4 numbers for a quaternion
    };
    std::vector<Block> blocks;
    Eigen::MatrixXd J;  // num_rows x sum of tangent sizes, in the order of `blocks`
    Eigen::VectorXd r_at;

    bool empty() const { return blocks.empty(); }
};

// What all residuals of `problem` say about its blocks but those `leaving`, by the Schur complement
// at the present estimate. Blocks that `before` holds are linearised where they were then. Constant
// blocks are taken as known.
LinearPrior marginalise(ceres::Problem& problem,
                        const std::vector<double*>& leaving,
                        const LinearPrior& before);

// The prior as a residual of `problem`, which must know its blocks already.
void add_prior(ceres::Problem& problem, const LinearPrior& prior);

}  // namespace divemesh::worker
