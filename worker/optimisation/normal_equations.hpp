#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "worker/optimisation/factor_graph.hpp"

namespace divemesh::optimisation {

// The columns, in tangent coordinates, of a graph's free blocks that have measurements.
struct Columns {
    std::vector<int> start;  // by block; -1: no column
    int num = 0;

    // Returns the columns, with those of `first` at the front in that order.
    static Columns of(const FactorGraph& graph, const std::vector<double*>& first = {});
};

// The second-order approximation (Gauss-Newton) of a graph around its current estimate:
//
//     cost(x) = c + b^T x + x^T H x / 2,   H = J^T W J,  b = J^T W r
//
// W: the weights of the robust losses. Landmarks are stored separately, three columns each, and
// eliminated by the Schur complement. The rest is dense, for sliding windows.
class NormalEquations {
public:
    // Keeps a reference to `graph`.
    NormalEquations(const FactorGraph& graph, Columns columns);

    // Linearises at the current values; derivatives are taken at first estimates where set.
    void linearise();
    double cost() const { return cost_; }

    struct Reduced {
        Eigen::MatrixXd H;  // lower triangle
        Eigen::VectorXd b;
    };
    // Returns the equations with the landmarks eliminated. The diagonal of H is first increased by
    // the fraction `damping` (Marquardt 1963). Without damping, undetermined landmarks add no
    // information.
    Reduced without_landmarks(double damping) const;

    struct Step {
        Eigen::VectorXd x;
        std::vector<Eigen::Vector3d> landmarks;
        double expected_decrease = 0.0;  // of the cost
    };
    // Returns the step; nullopt if the equations cannot be solved.
    std::optional<Step> step(double damping) const;

private:
    // (d r / d x)^T (d r / d landmark) of one observation and one of its blocks.
    struct Coupling {
        int start = 0;
        Eigen::Matrix3d W;
    };
    struct LandmarkTerm {
        Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
        Eigen::Vector3d b = Eigen::Vector3d::Zero();
        std::size_t first_coupling = 0;
        std::size_t last_coupling = 0;
    };
    void add(const Factor& factor);
    void add(const StereoFactor& seen, LandmarkTerm& landmark);
    int start(int block) const { return columns_.start[static_cast<std::size_t>(block)]; }
    const Block& block(int index) const { return graph_.blocks()[static_cast<std::size_t>(index)]; }

    const FactorGraph& graph_;
    Columns columns_;
    double cost_ = 0.0;
    Eigen::MatrixXd H_;
    Eigen::VectorXd b_;
    std::vector<LandmarkTerm> landmarks_;
    std::vector<Coupling> couplings_;
};

// Returns half the sum of squares at the current values, with losses. nullopt if a landmark is not
// in front of a camera that observes it.
std::optional<double> cost_of(const FactorGraph& graph);

}  // namespace divemesh::optimisation
