#include "worker/optimisation/sparse_inverse.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>

namespace divemesh::optimisation {
namespace {

// Solves Z L = L^-T D^-1 from the last column backwards. Column j of Z needs only the rows in L,
// and those need only entries of L in columns after j.
Eigen::SparseMatrix<double> invert(const Eigen::SparseMatrix<double>& L, const Eigen::VectorXd& D) {
    using Iterator = Eigen::SparseMatrix<double>::InnerIterator;
    const auto size = static_cast<int>(L.cols());
    // Iterators write to it. NOLINTNEXTLINE(performance-unnecessary-copy-initialization)
    Eigen::SparseMatrix<double> Z = L;
    std::vector<double> sum(static_cast<std::size_t>(size), 0.0);
    std::vector<double> factor(static_cast<std::size_t>(size), 0.0);
    std::vector<bool> in_column(static_cast<std::size_t>(size), false);
    for (int j = size - 1; j >= 0; --j) {
        for (Iterator l(L, j); l; ++l) {
            if (l.row() == j) continue;
            factor[static_cast<std::size_t>(l.row())] = l.value();
            in_column[static_cast<std::size_t>(l.row())] = true;
        }
        for (Iterator l(L, j); l; ++l) {
            const auto k = static_cast<int>(l.row());
            if (k == j) continue;
            double own = 0.0;
            for (Iterator z(Z, k); z; ++z) {
                const auto row = static_cast<std::size_t>(z.row());
                if (z.row() == k) {
                    own += z.value() * l.value();
                } else if (in_column[row]) {
                    sum[row] -= z.value() * l.value();
                    own += z.value() * factor[row];
                }
            }
            sum[static_cast<std::size_t>(k)] -= own;
        }
        double diagonal = 1.0 / D[j];
        for (Iterator l(L, j); l; ++l)
            if (l.row() > j) diagonal -= l.value() * sum[static_cast<std::size_t>(l.row())];
        for (Iterator z(Z, j); z; ++z) {
            const auto row = static_cast<std::size_t>(z.row());
            z.valueRef() = z.row() == j ? diagonal : sum[row];
            sum[row] = 0.0;
            factor[row] = 0.0;
            in_column[row] = false;
        }
    }
    return Z;
}

}  // namespace

std::optional<SparseInverse> SparseInverse::of(const Eigen::SparseMatrix<double>& lower) {
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(lower);
    if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() <= 0.0) return std::nullopt;
    Eigen::SparseMatrix<double> L = factor.matrixL();
    SparseInverse inverse;
    inverse.entries_ = invert(L, factor.vectorD());
    const auto& order = factor.permutationP().indices();
    inverse.place_.assign(order.data(), order.data() + order.size());
    return inverse;
}

double SparseInverse::operator()(int row, int column) const {
    const int a = place_[static_cast<std::size_t>(row)];
    const int b = place_[static_cast<std::size_t>(column)];
    const int* rows = entries_.innerIndexPtr();
    const int* begin = rows + entries_.outerIndexPtr()[std::min(a, b)];
    const int* end = rows + entries_.outerIndexPtr()[std::min(a, b) + 1];
    const int* found = std::lower_bound(begin, end, std::max(a, b));
    return found != end && *found == std::max(a, b) ? entries_.valuePtr()[found - rows] : 0.0;
}

Eigen::MatrixXd SparseInverse::block(int start, int size) const {
    Eigen::MatrixXd result(size, size);
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < size; ++j) result(i, j) = (*this)(start + i, start + j);
    return result;
}

}  // namespace divemesh::optimisation
