#include "worker/optimisation/residual_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/synthetic/stereo_world.hpp"

namespace divemesh::optimisation {
namespace {

constexpr int kNumDraws = 50;
constexpr double kNoise = 3.0;

using Nodes = Eigen::Matrix<double, kFieldSize, 1>;

// The residuals of a dive whose poses are known: the field's nodes, each with its own information,
// shift the scores, which have noise besides.
ClusteredInformation scores_of(double sigma_px, std::mt19937& random) {
    std::normal_distribution<double> normal;
    ClusteredInformation information{Eigen::SparseMatrix<double>(1, 1),
                                     Eigen::SparseMatrix<double>(1, 1),
                                     Eigen::MatrixXd::Zero(1, kFieldSize),
                                     SharedScores(1, kFieldSize),
                                     {0}};
    for (int i = 0; i < kFieldSize; ++i) {
        const double own = 20.0 + i;
        information.of_shared.information(i, i) = own;
        information.of_shared.sum[i] = own * sigma_px * normal(random) + kNoise * normal(random);
        information.of_shared.variances[i] = kNoise * kNoise;
    }
    return information;
}

double mean_variance(double sigma_px) {
    std::mt19937 random(1);
    double mean = 0.0;
    for (int draw = 0; draw < kNumDraws; ++draw)
        mean +=
            field_variance(scores_of(sigma_px, random), Eigen::MatrixXd::Zero(1, kFieldSize), 0) /
            kNumDraws;
    return mean;
}

TEST(ResidualFieldTest, ItsVarianceIsFoundBesideNoise) {
    EXPECT_NEAR(std::sqrt(mean_variance(0.2)), 0.2, 0.01);
}

TEST(ResidualFieldTest, NoiseAloneShowsHardlyAField) {
    EXPECT_LT(std::sqrt(mean_variance(0.0)), 0.02);
}

TEST(ResidualFieldTest, IsLinearBetweenNodes) {
    const types::RectifiedRig rig = synthetic::rig();
    Nodes nodes = Nodes::Zero();
    for (int row = 0; row < kFieldRows; ++row)
        for (int column = 0; column < kFieldColumns; ++column)
            nodes.segment<3>(3 * (row * kFieldColumns + column)) << column, row, column + row;

    const double u = 0.37;
    const double v = 0.81;
    const Eigen::Vector3d shift =
        by_field(rig, {u * rig.width_px, v * rig.height_px, 10.0}) * nodes;

    const Eigen::Vector3d expected(u * (kFieldColumns - 1), v * (kFieldRows - 1), 0.0);
    EXPECT_NEAR(shift.x(), expected.x(), 1e-9);
    EXPECT_NEAR(shift.y(), expected.y(), 1e-9);
    EXPECT_NEAR(shift.z(), expected.x() + expected.y(), 1e-9);
}

}  // namespace
}  // namespace divemesh::optimisation
