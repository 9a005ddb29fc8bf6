#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/optimisation/factor_graph.hpp"

namespace divemesh::optimisation {

// What measurements that are kept no longer said about the parameters that are: a Gaussian in
// square-root form,
//
//     r(x) = J (x - at) + r_at          - : the difference of each block's manifold
//
// J stays as it was first estimated, whatever x becomes: what was unobservable then stays so
// (first-estimate Jacobians; Huang, Mourikis and Roumeliotis, "Observability-based rules for
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

// What a graph says about its free blocks but those `leaving`, and but its landmarks, by the Schur
// complement at the present estimate; derivatives are taken at the first estimates that the graph
// knows, which stay. Fixed blocks are taken as known.
LinearPrior marginalise(FactorGraph& graph, const std::vector<double*>& leaving);

// The prior as a factor of `graph`, and as the first estimate of its blocks. What is no vector must
// be known to the graph already.
void add_prior(FactorGraph& graph, const LinearPrior& prior);

}  // namespace divemesh::optimisation
