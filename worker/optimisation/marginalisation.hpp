#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/optimisation/factor_graph.hpp"

namespace divemesh::optimisation {

// The marginalisation prior: the information of dropped measurements about the remaining
// parameters, as a Gaussian in square-root form,
//
//     r(x) = J (x - at) + r_at          - : the difference of each block's manifold
//
// J keeps its first linearisation while x changes, so that unobservable directions stay
// unobservable (first-estimate Jacobians; Huang, Mourikis and Roumeliotis, "Observability-based
// rules for designing consistent EKF SLAM estimators", 2010). Blocks are identified by the address
// of their values.
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

// Returns the prior of a graph's free blocks without the `leaving` blocks and the landmarks, by the
// Schur complement at the current estimate. Derivatives are taken at the graph's first estimates,
// which stay. Fixed blocks are taken as known.
LinearPrior marginalise(FactorGraph& graph, const std::vector<double*>& leaving);

// Adds the prior to `graph` as a factor and sets the first estimates of its blocks. Blocks that are
// not vectors must exist in the graph already.
void add_prior(FactorGraph& graph, const LinearPrior& prior);

}  // namespace divemesh::optimisation
