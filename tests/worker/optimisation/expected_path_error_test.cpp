#include "worker/optimisation/expected_path_error.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/synthetic/trajectory_error.hpp"

namespace divemesh::optimisation {
namespace {

constexpr int kNumPositions = 40;
constexpr int kNumRuns = 2000;
constexpr double kStepSigma_m = 0.01;

using Path = std::vector<Eigen::Vector3d>;

Path curved_path() {
    Path path;
    for (int i = 0; i < kNumPositions; ++i)
        path.emplace_back(0.2 * i, std::sin(0.2 * i), 0.3 * std::cos(0.1 * i));
    return path;
}

// Returns the covariance of a path with independent errors per step: the covariance of positions i
// and j is that of their common part.
Eigen::MatrixXd random_walk_covariance() {
    Eigen::MatrixXd covariance(3 * kNumPositions, 3 * kNumPositions);
    for (int i = 0; i < kNumPositions; ++i)
        for (int j = 0; j < kNumPositions; ++j)
            covariance.block<3, 3>(3 * i, 3 * j) =
                kStepSigma_m * kStepSigma_m * std::min(i, j) * Eigen::Matrix3d::Identity();
    return covariance;
}

Path walked(Path path, std::mt19937& random) {
    std::normal_distribution<double> step(0.0, kStepSigma_m);
    Eigen::Vector3d off = Eigen::Vector3d::Zero();
    for (int i = 1; i < kNumPositions; ++i) {
        off += Eigen::Vector3d(step(random), step(random), step(random));
        path[static_cast<std::size_t>(i)] += off;
    }
    return path;
}

double share_below(const std::vector<double>& values, double limit) {
    return static_cast<double>(std::count_if(
               values.begin(), values.end(), [&](double value) { return value <= limit; })) /
           static_cast<double>(values.size());
}

TEST(PathUncertaintyTest, BoundsTheErrorsOfRandomWalksAfterAlignment) {
    const Path truth = curved_path();
    const types::PathUncertainty path = after_alignment(truth, random_walk_covariance());
    std::mt19937 random(1);
    std::vector<double> errors_m2;
    double mean_m2 = 0.0;
    for (int run = 0; run < kNumRuns; ++run) {
        errors_m2.push_back(synthetic::squared_ate_m2(walked(truth, random), truth));
        mean_m2 += errors_m2.back() / kNumRuns;
    }
    EXPECT_NEAR(path.mean_square_m2, mean_m2, 0.05 * mean_m2);
    EXPECT_NEAR(share_below(errors_m2, quantile_95(path.mean_square_m2, path.degrees_of_freedom)),
                0.95,
                0.015);
}

TEST(PathUncertaintyTest, RigidMotionsAreNoError) {
    // All positions have the same error.
    const Eigen::MatrixXd same =
        Eigen::Matrix3d::Identity().replicate(kNumPositions, kNumPositions);
    EXPECT_LT(after_alignment(curved_path(), same).mean_square_m2, 1e-9);
}

TEST(PathUncertaintyTest, AWalkThatIsNotAlignedHasTheVarianceOfItsSteps) {
    const Eigen::Matrix3d end = random_walk_covariance().bottomRightCorner<3, 3>();
    // 7.8147: the 95 % quantile of chi-square with three degrees of freedom.
    const double expected = 7.8147 * 39 * kStepSigma_m * kStepSigma_m;
    EXPECT_NEAR(squared_length_95(end), expected, 1e-4 * expected);
}

TEST(PathUncertaintyTest, AnErrorAlongOneAxisIsBoundedAsANormalNumber) {
    Eigen::Matrix3d along = Eigen::Matrix3d::Zero();
    along(0, 0) = 0.04;
    EXPECT_NEAR(std::sqrt(squared_length_95(along)), 1.959964 * 0.2, 1e-6);
}

// Returns the slope of true over estimated heights, fitted together with a tilt.
double height_factor(const Path& estimate, const Path& truth) {
    Eigen::MatrixX4d columns(kNumPositions, 4);
    Eigen::VectorXd heights(kNumPositions);
    for (int i = 0; i < kNumPositions; ++i) {
        const Eigen::Vector3d& p = estimate[static_cast<std::size_t>(i)];
        columns.row(i) << p.z(), p.x(), p.y(), 1.0;
        heights[i] = truth[static_cast<std::size_t>(i)].z();
    }
    return columns.colPivHouseholderQr().solve(heights)[0];
}

TEST(PathUncertaintyTest, TheErrorOfAHeightFactorMatchesItsSigma) {
    Path truth = curved_path();
    for (Eigen::Vector3d& p : truth) p.z() += 0.5 * std::sin(1.5 * p.x());
    const double sigma = vertical_scale_sigma(truth, random_walk_covariance());
    std::mt19937 random(3);
    double squares = 0.0;
    for (int run = 0; run < kNumRuns; ++run)
        squares += std::pow(height_factor(walked(truth, random), truth) - 1.0, 2.0);
    EXPECT_NEAR(sigma, std::sqrt(squares / kNumRuns), 0.06 * sigma);
    EXPECT_EQ(vertical_scale_sigma(Path(kNumPositions, Eigen::Vector3d::Zero()),
                                   random_walk_covariance()),
              0.0);
}

TEST(PathUncertaintyTest, FramesBetweenKeyframesAddWhatFollowingAdds) {
    types::CovarianceTrack keyframes(2);
    keyframes[1].timestamp_ns = 100;
    types::CovarianceTrack frames(4);
    for (std::size_t i = 0; i < frames.size(); ++i)
        frames[i].timestamp_ns = 25 * static_cast<std::int64_t>(i);
    frames[1].position_m2 = 4.0 * Eigen::Matrix3d::Identity();
    EXPECT_NEAR(
        with_frames_between({1.0, 5.0}, keyframes, frames).mean_square_m2, 1.0 + 3.0, 1e-12);
    EXPECT_FALSE(with_frames_between({}, keyframes, frames).is_known());
}

}  // namespace
}  // namespace divemesh::optimisation
