#include "worker/estimation/marginalisation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <ceres/crs_matrix.h>
#include <ceres/manifold.h>
#include <set>

namespace divemesh::worker {
namespace {

// Directions that the leaving measurements said nothing about, relative to the strongest.
constexpr double kNoInformation = 1e-14;

// b - a in the tangent space at a.
Eigen::VectorXd difference(const ceres::Manifold* manifold,
                           const double* b,
                           const Eigen::VectorXd& a) {
    if (!manifold) return Eigen::Map<const Eigen::VectorXd>(b, a.size()) - a;
    Eigen::VectorXd delta(manifold->TangentSize());
    manifold->Minus(b, a.data(), delta.data());
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
            const Eigen::VectorXd delta = difference(manifolds_[b], parameters[b], at);
            const auto J = prior_.J.middleCols(column, delta.size());
            r += J * delta;
            column += delta.size();
            if (!jacobians || !jacobians[b]) continue;
            Eigen::Map<RowMajor> out(jacobians[b], r.size(), at.size());
            if (!manifolds_[b]) {
                out = J;
                continue;
            }
            // The solver multiplies by the plus operation's derivative at x: this undoes it.
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

// The free blocks of a problem, those that leave first, and all its residuals.
struct Unknowns {
    std::vector<double*> blocks;
    std::size_t num_leaving = 0;
    std::vector<ceres::ResidualBlockId> residuals;
};

Unknowns unknowns_of(const ceres::Problem& problem, const std::vector<double*>& leaving) {
    Unknowns result;
    for (double* block : leaving)
        if (problem.HasParameterBlock(block) && !problem.IsParameterBlockConstant(block))
            result.blocks.push_back(block);
    result.num_leaving = result.blocks.size();
    const std::set<double*> leaves(leaving.begin(), leaving.end());
    std::set<double*> known;
    problem.GetResidualBlocks(&result.residuals);
    for (const auto residual : result.residuals) {
        std::vector<double*> blocks;
        problem.GetParameterBlocksForResidualBlock(residual, &blocks);
        for (double* block : blocks)
            if (!leaves.contains(block) && !problem.IsParameterBlockConstant(block) &&
                known.insert(block).second)
                result.blocks.push_back(block);
    }
    return result;
}

Eigen::MatrixXd dense(const ceres::CRSMatrix& sparse) {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
    for (int row = 0; row < sparse.num_rows; ++row)
        for (int i = sparse.rows[static_cast<std::size_t>(row)];
             i < sparse.rows[static_cast<std::size_t>(row) + 1];
             ++i)
            result(row, sparse.cols[static_cast<std::size_t>(i)]) =
                sparse.values[static_cast<std::size_t>(i)];
    return result;
}

struct Linearised {
    Eigen::MatrixXd J;
    Eigen::VectorXd r;
};

Linearised linearise(ceres::Problem& problem, const Unknowns& unknowns) {
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = unknowns.blocks;
    options.residual_blocks = unknowns.residuals;
    options.num_threads = 1;
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;
    problem.Evaluate(options, nullptr, &residuals, nullptr, &jacobian);
    return {dense(jacobian), Eigen::Map<Eigen::VectorXd>(residuals.data(), std::ssize(residuals))};
}

// Puts the blocks of a prior to where it was linearised, and back when it goes.
class AtFirstEstimate {
public:
    explicit AtFirstEstimate(const LinearPrior& prior) : prior_(prior) {
        for (const auto& block : prior_.blocks) {
            const Eigen::Map<Eigen::VectorXd> values(block.values, block.at.size());
            present_.emplace_back(values);
            Eigen::Map<Eigen::VectorXd>(block.values, block.at.size()) = block.at;
        }
    }
    ~AtFirstEstimate() {
        for (std::size_t b = 0; b < present_.size(); ++b)
            Eigen::Map<Eigen::VectorXd>(prior_.blocks[b].values, present_[b].size()) = present_[b];
    }
    AtFirstEstimate(const AtFirstEstimate&) = delete;
    AtFirstEstimate& operator=(const AtFirstEstimate&) = delete;

private:
    const LinearPrior& prior_;
    std::vector<Eigen::VectorXd> present_;
};

// A symmetric H and b = J^T r as a square-root form of no more rows than H has rank.
Linearised square_root(const Eigen::MatrixXd& H, const Eigen::VectorXd& b) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (H + H.transpose()));
    const double least = kNoInformation * std::max(1e-300, eigen.eigenvalues().maxCoeff());
    const Eigen::Index num = (eigen.eigenvalues().array() > least).count();
    const auto vectors = eigen.eigenvectors().rightCols(num);
    const Eigen::VectorXd roots = eigen.eigenvalues().tail(num).cwiseSqrt();
    return {roots.asDiagonal() * vectors.transpose(),
            roots.cwiseInverse().asDiagonal() * vectors.transpose() * b};
}

// The Schur complement of the first `num_leaving` unknowns. Those that nothing holds leave without
// a word.
Linearised without_first(const Linearised& all, Eigen::Index num_leaving) {
    const Eigen::Index num_kept = all.J.cols() - num_leaving;
    const Eigen::MatrixXd H = all.J.transpose() * all.J;
    const Eigen::VectorXd b = all.J.transpose() * all.r;
    if (num_leaving == 0) return square_root(H, b);
    const Eigen::MatrixXd H_leaving = H.topLeftCorner(num_leaving, num_leaving);
    // Scaled to a unit diagonal: units must not decide what counts as unobserved.
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

LinearPrior marginalise(ceres::Problem& problem,
                        const std::vector<double*>& leaving,
                        const LinearPrior& before) {
    const Unknowns unknowns = unknowns_of(problem, leaving);
    if (unknowns.residuals.empty() || unknowns.blocks.size() == unknowns.num_leaving) return {};
    Linearised all = linearise(problem, unknowns);
    {
        const AtFirstEstimate first(before);
        all.J = linearise(problem, unknowns).J;
    }
    LinearPrior prior;
    Eigen::Index num_leaving = 0;
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < unknowns.blocks.size(); ++i) {
        double* values = unknowns.blocks[i];
        const int size = problem.ParameterBlockTangentSize(values);
        LinearPrior::Block block{
            values, size, Eigen::Map<Eigen::VectorXd>(values, problem.ParameterBlockSize(values))};
        for (const auto& known : before.blocks)
            if (known.values == values) block.at = known.at;
        // The residuals as a function of the distance from `at`.
        all.r -= all.J.middleCols(column, size) *
                 difference(problem.GetManifold(values), values, block.at);
        column += size;
        if (i < unknowns.num_leaving)
            num_leaving += size;
        else
            prior.blocks.push_back(std::move(block));
    }
    const Linearised rest = without_first(all, num_leaving);
    prior.J = rest.J;
    prior.r_at = rest.r;
    return prior;
}

void add_prior(ceres::Problem& problem, const LinearPrior& prior) {
    if (prior.empty()) return;
    std::vector<double*> blocks;
    std::vector<const ceres::Manifold*> manifolds;
    for (const auto& block : prior.blocks) {
        blocks.push_back(block.values);
        manifolds.push_back(problem.GetManifold(block.values));
    }
    problem.AddResidualBlock(new PriorCost(prior, std::move(manifolds)), nullptr, blocks);
}

}  // namespace divemesh::worker
