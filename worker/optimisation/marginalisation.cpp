#include "worker/optimisation/marginalisation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <memory>
#include <utility>

#include "worker/optimisation/normal_equations.hpp"

namespace divemesh::optimisation {
namespace {

// Eigenvalue, relative to the largest, below which the leaving measurements do not observe a
// direction.
constexpr double kNoInformation = 1e-14;

// Returns b - a in the tangent space at a.
Eigen::VectorXd difference(const ceres::Manifold* manifold,
                           const double* b,
                           const double* a,
                           int size) {
    if (!manifold)
        return Eigen::Map<const Eigen::VectorXd>(b, size) -
               Eigen::Map<const Eigen::VectorXd>(a, size);
    Eigen::VectorXd delta(manifold->TangentSize());
    manifold->Minus(b, a, delta.data());
    return delta;
}

class PriorCost : public ceres::CostFunction {
public:
    PriorCost(const LinearPrior& prior, std::vector<const ceres::Manifold*> manifolds)
        : prior_(prior), manifolds_(std::move(manifolds)) {
        for (const auto& block : prior_.blocks)
            mutable_parameter_block_sizes()->push_back(static_cast<int>(block.at.size()));
        set_num_residuals(static_cast<int>(prior_.r_at.size()));
    }

    bool Evaluate(double const* const* parameters,
                  double* residuals,
                  double** jacobians) const override {
        using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        Eigen::Map<Eigen::VectorXd> r(residuals, prior_.r_at.size());
        r = prior_.r_at;
        Eigen::Index column = 0;
        for (std::size_t b = 0; b < prior_.blocks.size(); ++b) {
            const auto& at = prior_.blocks[b].at;
            const Eigen::VectorXd delta =
                difference(manifolds_[b], parameters[b], at.data(), static_cast<int>(at.size()));
            const auto J = prior_.J.middleCols(column, delta.size());
            r += J * delta;
            column += delta.size();
            if (!jacobians || !jacobians[b]) continue;
            Eigen::Map<RowMajor> out(jacobians[b], r.size(), at.size());
            if (!manifolds_[b]) {
                out = J;
                continue;
            }
            // The solver multiplies by the derivative of the plus operation at x; this undoes it.
            RowMajor minus(delta.size(), at.size());
            manifolds_[b]->MinusJacobian(parameters[b], minus.data());
            out = J * minus;
        }
        return true;
    }

private:
    const LinearPrior prior_;
    const std::vector<const ceres::Manifold*> manifolds_;
};

struct SquareRoot {
    Eigen::MatrixXd J;
    Eigen::VectorXd r;
};

// Returns a symmetric H and b = J^T r in square-root form, with at most rank(H) rows.
SquareRoot square_root(const Eigen::MatrixXd& H, const Eigen::VectorXd& b) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (H + H.transpose()));
    const double min_eigenvalue = kNoInformation * std::max(1e-300, eigen.eigenvalues().maxCoeff());
    const Eigen::Index num = (eigen.eigenvalues().array() > min_eigenvalue).count();
    const auto vectors = eigen.eigenvectors().rightCols(num);
    const Eigen::VectorXd roots = eigen.eigenvalues().tail(num).cwiseSqrt();
    return {roots.asDiagonal() * vectors.transpose(),
            roots.cwiseInverse().asDiagonal() * vectors.transpose() * b};
}

// Returns the Schur complement of the first `num_leaving` unknowns. Unobserved ones among them add
// no information.
SquareRoot without_first(const Eigen::MatrixXd& H,
                         const Eigen::VectorXd& b,
                         Eigen::Index num_leaving) {
    const Eigen::Index num_kept = H.cols() - num_leaving;
    if (num_leaving == 0) return square_root(H, b);
    const Eigen::MatrixXd H_leaving = H.topLeftCorner(num_leaving, num_leaving);
    // Scaled to a unit diagonal, so that units do not affect what counts as unobserved.
    const Eigen::VectorXd scale = H_leaving.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * H_leaving *
                                                               scale.asDiagonal());
    const Eigen::VectorXd inverse =
        (eigen.eigenvalues().array() > 1e-12).select(eigen.eigenvalues().cwiseInverse(), 0.0);
    const Eigen::MatrixXd whiten =
        inverse.cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose() * scale.asDiagonal();
    const Eigen::MatrixXd coupling = whiten * H.topRightCorner(num_leaving, num_kept);
    return square_root(H.bottomRightCorner(num_kept, num_kept) - coupling.transpose() * coupling,
                       b.tail(num_kept) - coupling.transpose() * (whiten * b.head(num_leaving)));
}

}  // namespace

LinearPrior marginalise(FactorGraph& graph, const std::vector<double*>& leaving) {
    graph.drop_unseen();
    const Columns columns = Columns::of(graph, leaving);
    NormalEquations equations(graph, columns);
    equations.linearise();
    const auto reduced = equations.without_landmarks(0.0);
    const Eigen::MatrixXd H = reduced.H.selfadjointView<Eigen::Lower>();

    LinearPrior prior;
    Eigen::VectorXd moved(columns.num);  // since the first estimates
    Eigen::Index num_leaving = 0;
    for (std::size_t i = 0; i < graph.blocks().size(); ++i) {
        const Block& block = graph.blocks()[i];
        if (columns.start[i] < 0) continue;
        const int size = block.tangent_size();
        moved.segment(columns.start[i], size) =
            difference(block.manifold, block.values, block.linearised_at(), block.size);
        if (std::find(leaving.begin(), leaving.end(), block.values) != leaving.end())
            num_leaving += size;
        else
            prior.blocks.push_back(
                {block.values,
                 size,
                 Eigen::Map<const Eigen::VectorXd>(block.linearised_at(), block.size)});
    }
    if (prior.blocks.empty()) return {};
    // The gradient at the first estimates of the blocks, not at their current values.
    const SquareRoot rest = without_first(H, reduced.b - H * moved, num_leaving);
    prior.J = rest.J;
    prior.r_at = rest.r;
    return prior;
}

void add_prior(FactorGraph& graph, const LinearPrior& prior) {
    if (prior.empty()) return;
    std::vector<double*> blocks;
    std::vector<const ceres::Manifold*> manifolds;
    for (const auto& block : prior.blocks) {
        blocks.push_back(block.values);
        const int index = graph.add_block(block.values, static_cast<int>(block.at.size()));
        manifolds.push_back(graph.blocks()[static_cast<std::size_t>(index)].manifold);
        graph.set_first_estimate(block.values, block.at);
    }
    graph.add_factor(std::make_unique<PriorCost>(prior, std::move(manifolds)), nullptr, blocks);
}

}  // namespace divemesh::optimisation
