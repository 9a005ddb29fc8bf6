#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <vector>

namespace divemesh::optimisation {

// The inverse of a sparse symmetric positive definite matrix, only at the entries of its Cholesky
// factor: that includes every block of the matrix itself, at about the cost of the factorisation
// (Takahashi, Fagan and Chen, "Formation of a sparse bus impedance matrix", 1973; Erisman and
// Tinney, "On computing certain elements of the inverse of a sparse matrix", 1975).
class SparseInverse {
public:
    // Returns the inverse of the matrix with this lower triangle; nullopt if it is not positive
    // definite.
    static std::optional<SparseInverse> of(const Eigen::SparseMatrix<double>& lower);

    // Returns an entry of the inverse; 0 if the factor has no such entry.
    double operator()(int row, int column) const;
    // Returns the block of rows and columns start .. start + size - 1.
    Eigen::MatrixXd block(int start, int size) const;

private:
    std::vector<int> place_;               // position of a row in the factor's order
    Eigen::SparseMatrix<double> entries_;  // lower triangle in the factor's order
};

}  // namespace divemesh::optimisation
