#include "worker/texture/solve_smooth_system.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cmath>

namespace divemesh::texture {
namespace {

// Returns the Laplacian of a grid of side x side points that are weakly held at 0.
SymmetricMatrix grid_laplacian(int side) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto join = [&](int a, int b) {
        entries.emplace_back(a, a, 1.0);
        entries.emplace_back(b, b, 1.0);
        entries.emplace_back(a, b, -1.0);
        entries.emplace_back(b, a, -1.0);
    };
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const int at = row * side + column;
            entries.emplace_back(at, at, 1e-5);
            if (column + 1 < side) join(at, at + 1);
            if (row + 1 < side) join(at, at + side);
        }
    SymmetricMatrix matrix(side * side, side * side);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

TEST(SolveSmoothSystem, AgreesWithADirectSolution) {
    constexpr int kSide = 150;
    const SymmetricMatrix matrix = grid_laplacian(kSide);
    Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(matrix.rows(), 3);
    for (int row = 0; row < kSide; ++row) {  // a step of 10 across the middle, 5, and none
        right.row(row * kSide + kSide / 2) << 10.0, 5.0 * std::sin(0.1 * row), 0.0;
        right.row(row * kSide + kSide / 2 + 1) = -right.row(row * kSide + kSide / 2);
    }
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor{
        Eigen::SparseMatrix<double>(matrix)};
    const Eigen::MatrixX3d expected = factor.solve(right);
    const Eigen::MatrixX3d solution = solve_smooth_system(matrix, right, {});
    EXPECT_LT((solution - expected).cwiseAbs().maxCoeff(), 0.01 * expected.cwiseAbs().maxCoeff());
    EXPECT_EQ(solution.col(2).norm(), 0.0);
}

}  // namespace
}  // namespace divemesh::texture
