#include "worker/optimisation/sparse_inverse.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace divemesh::optimisation {
namespace {

// Returns a chain of 3x3 blocks with some loops, like the poses of a dive.
Eigen::MatrixXd chain_with_loops(int num_blocks) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const int size = 3 * num_blocks;
    Eigen::MatrixXd H = 0.1 * Eigen::MatrixXd::Identity(size, size);
    const auto tie = [&](int a, int b) {
        Eigen::MatrixXd J = Eigen::MatrixXd::Zero(4, size);
        for (int row = 0; row < 4; ++row)
            for (int i = 0; i < 3; ++i) {
                J(row, 3 * a + i) = normal(random);
                J(row, 3 * b + i) = normal(random);
            }
        H += J.transpose() * J;
    };
    for (int k = 1; k < num_blocks; ++k) tie(k - 1, k);
    for (int k = 0; k + 9 < num_blocks; k += 5) tie(k, k + 9);
    return H;
}

TEST(SparseInverseTest, HasTheEntriesOfTheInverseWhereTheMatrixHasSome) {
    const Eigen::MatrixXd H = chain_with_loops(40);
    const Eigen::SparseMatrix<double> sparse = H.sparseView();

    const auto inverse = SparseInverse::of(sparse.triangularView<Eigen::Lower>());

    ASSERT_TRUE(inverse);
    const Eigen::MatrixXd expected = H.inverse();
    for (int i = 0; i < H.rows(); ++i)
        for (int j = 0; j < H.cols(); ++j) {
            if (H(i, j) == 0.0) continue;
            EXPECT_NEAR((*inverse)(i, j), expected(i, j), 1e-9);
        }
    EXPECT_LT((inverse->block(36, 3) - expected.block(36, 36, 3, 3)).norm(), 1e-9);
}

TEST(SparseInverseTest, RefusesAMatrixThatIsNotPositiveDefinite) {
    Eigen::MatrixXd H = chain_with_loops(3);
    H(4, 4) = -1.0;
    const Eigen::SparseMatrix<double> sparse = H.sparseView();

    EXPECT_FALSE(SparseInverse::of(sparse.triangularView<Eigen::Lower>()));
}

}  // namespace
}  // namespace divemesh::optimisation
