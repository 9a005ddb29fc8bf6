#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <vector>

namespace divemesh::optimisation {

// The inverse of a sparse symmetric positive definite matrix, only where its Cholesky factor has
// entries: enough for every block that the matrix itself has, at about the cost of the
// factorisation (Takahashi, Fagan and Chen, "Formation of a sparse bus impedance matrix", 1973;
// Erisman and Tinney, "On computing certain elements of the inverse of a sparse matrix", 1975).
class SparseInverse {
public:
    // Of the matrix whose lower triangle is `lower`. Nothing when it is not positive definite.
    static std::optional<SparseInverse> of(const Eigen::SparseMatrix<double>& lower);

    // 0 where the factor has no entry.
    double operator()(int row, int column) const;
    // Rows and columns start .. start + size - 1.
    Eigen::MatrixXd block(int start, int size) const;

private:
    std::vector<int> place_;               // of a row in the factor's order
    Eigen::SparseMatrix<double> entries_;  // lower triangle in the factor's order
};

}  // namespace divemesh::optimisation
