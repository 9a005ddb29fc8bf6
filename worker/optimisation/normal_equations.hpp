#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "worker/optimisation/factor_graph.hpp"

namespace divemesh::optimisation {

// Where the free blocks of a graph that something was measured of have their columns, in tangent
// coordinates.
struct Columns {
    std::vector<int> start;  // by block; -1: none
    int num = 0;

    // Those of `first` come first, in that order.
    static Columns of(const FactorGraph& graph, const std::vector<double*>& first = {});
};

// A graph around its present estimate, to second order by Gauss and Newton:
//
//     cost(x) = c + b^T x + x^T H x / 2,   H = J^T W J,  b = J^T W r
//
// W: the weights of robust losses. Landmarks are kept apart, three columns each, and eliminated by
// the Schur complement. Dense: for windows.
class NormalEquations {
public:
    // Refers to `graph`.
    NormalEquations(const FactorGraph& graph, Columns columns);

    // At the present values; derivatives at the first estimates where there are any.
    void linearise();
    double cost() const { return cost_; }

    struct Reduced {
        Eigen::MatrixXd H;  // lower triangle
        Eigen::VectorXd b;
    };
    // Without the landmarks. The diagonal of H is raised by `damping` of itself first
    // (Marquardt 1963). Without damping, landmarks that are not determined say nothing.
    Reduced without_landmarks(double damping) const;

    struct Step {
        Eigen::VectorXd x;
        std::vector<Eigen::Vector3d> landmarks;
        double expected_decrease = 0.0;  // of the cost
    };
    // Nothing where the equations cannot be solved.
    std::optional<Step> step(double damping) const;

private:
    // d r / d x^T d r / d landmark of one observation and one of its blocks.
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

// Half the sum of squares at the present values, under the losses. Nothing where a landmark is not
// in front of a camera that sees it.
std::optional<double> cost_of(const FactorGraph& graph);

}  // namespace divemesh::optimisation
