#include "worker/texture/solve_smooth_system.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace divemesh::texture {
namespace {

using Columns = Eigen::MatrixX3d;

constexpr double kMaxResidual = 1e-4;
constexpr int kMaxSteps = 300;

// Returns the group of each unknown: one that has none yet, with its neighbours and theirs. Only
// unknowns that depend strongly on each other are neighbours (Vanek, Mandel and Brezina 1996).
std::vector<int> groups_of(const SymmetricMatrix& matrix) {
    constexpr double kStrong = 0.05;
    constexpr int kNone = -1;
    const Eigen::VectorXd diagonal = matrix.diagonal();
    std::vector<int> groups(static_cast<std::size_t>(matrix.rows()), kNone);
    std::vector<Eigen::Index> joined;
    const auto join_neighbours = [&](Eigen::Index i, int group) {
        for (SymmetricMatrix::InnerIterator entry(matrix, i); entry; ++entry) {
            if (groups[entry.col()] != kNone ||
                std::abs(entry.value()) < kStrong * std::sqrt(diagonal[i] * diagonal[entry.col()]))
                continue;
            groups[entry.col()] = group;
            joined.push_back(entry.col());
        }
    };
    int num_groups = 0;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
        if (groups[i] != kNone) continue;
        groups[i] = num_groups;
        joined.clear();
        join_neighbours(i, num_groups);
        const std::size_t num_neighbours = joined.size();
        for (std::size_t k = 0; k < num_neighbours; ++k) join_neighbours(joined[k], num_groups);
        ++num_groups;
    }
    return groups;
}

// An approximate inverse: the diagonal's, plus the inverse of the matrix summed over groups.
class Preconditioner {
public:
    explicit Preconditioner(const SymmetricMatrix& matrix)
        : inverse_diagonal_(matrix.diagonal().cwiseInverse()), groups_(groups_of(matrix)) {
        const int num_groups = 1 + *std::max_element(groups_.begin(), groups_.end());
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(static_cast<std::size_t>(matrix.nonZeros()));
        for (Eigen::Index i = 0; i < matrix.rows(); ++i)
            for (SymmetricMatrix::InnerIterator entry(matrix, i); entry; ++entry)
                if (groups_[i] >= groups_[entry.col()])
                    entries.emplace_back(groups_[i], groups_[entry.col()], entry.value());
        Eigen::SparseMatrix<double> coarse(num_groups, num_groups);
        coarse.setFromTriplets(entries.begin(), entries.end());
        factor_.compute(coarse);
    }

    Columns apply(const Columns& residual) const {
        Columns sums = Columns::Zero(factor_.rows(), 3);
        for (Eigen::Index i = 0; i < residual.rows(); ++i) sums.row(groups_[i]) += residual.row(i);
        const Columns coarse = factor_.solve(sums);
        Columns result = inverse_diagonal_.asDiagonal() * residual;
        for (Eigen::Index i = 0; i < residual.rows(); ++i) result.row(i) += coarse.row(groups_[i]);
        return result;
    }

private:
    Eigen::VectorXd inverse_diagonal_;
    std::vector<int> groups_;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;  // of the lower triangle
};

Eigen::RowVector3d dots(const Columns& a, const Columns& b) {
    return a.cwiseProduct(b).colwise().sum();
}

// Returns a / b; 0 for a channel that has converged.
Eigen::RowVector3d ratios(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b) {
    return (b.array() > 0.0).select(a.array() / b.array(), 0.0);
}

}  // namespace

Eigen::MatrixX3d solve_smooth_system(const SymmetricMatrix& matrix,
                                     const Eigen::MatrixX3d& right,
                                     const base::ProgressShare& progress) {
    progress.at(0.0);
    const Preconditioner preconditioner(matrix);
    const Eigen::RowVector3d limits = kMaxResidual * kMaxResidual * dots(right, right);
    Columns x = Columns::Zero(right.rows(), 3);
    Columns residual = right;
    Columns direction = preconditioner.apply(residual);
    Eigen::RowVector3d energy = dots(residual, direction);
    for (int step = 0; step < kMaxSteps; ++step) {
        progress.at(static_cast<double>(step + 1) / kMaxSteps);
        if ((dots(residual, residual).array() <= limits.array()).all()) break;
        const Columns image = matrix * direction;
        const Eigen::RowVector3d length = ratios(energy, dots(direction, image));
        x += direction * length.asDiagonal();
        residual -= image * length.asDiagonal();
        const Columns preconditioned = preconditioner.apply(residual);
        const Eigen::RowVector3d next_energy = dots(residual, preconditioned);
        direction = preconditioned + direction * ratios(next_energy, energy).asDiagonal();
        energy = next_energy;
    }
    return x;
}

}  // namespace divemesh::texture
