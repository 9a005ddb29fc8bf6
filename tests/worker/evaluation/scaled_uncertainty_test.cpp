#include "worker/evaluation/scaled_uncertainty.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/synthetic/trajectory_error.hpp"
#include "worker/evaluation/combined_scale.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/optimisation/expected_path_error.hpp"

namespace divemesh::evaluation {
namespace {

constexpr int kNumPositions = 40;
constexpr int kNumDraws = 2000;
constexpr double kStepSigma_m = 0.001;

using Positions = std::vector<Eigen::Vector3d>;

// A path of 8 m with a random walk as its error, beside that of its scale.
struct Path {
    explicit Path(double scale_sigma) {
        Eigen::MatrixXd covariance_m2(3 * kNumPositions, 3 * kNumPositions);
        for (int i = 0; i < kNumPositions; ++i) {
            truth.emplace_back(0.2 * i, std::sin(0.2 * i), 0.3 * std::cos(0.1 * i) - 0.3);
            trajectory.push_back({1 + i, Eigen::Isometry3d::Identity()});
            trajectory.back().T_world_imu.translation() = truth.back();
        }
        for (int i = 0; i < kNumPositions; ++i)
            for (int j = 0; j < kNumPositions; ++j)
                covariance_m2.block<3, 3>(3 * i, 3 * j) =
                    kStepSigma_m * kStepSigma_m * std::min(i, j) * Eigen::Matrix3d::Identity() +
                    scale_sigma * scale_sigma * at(i) * at(j).transpose();
        uncertainty = optimisation::after_alignment(truth, covariance_m2);
        uncertainty.scale_sigma = optimisation::scale_sigma(truth, covariance_m2);
        uncertainty.shared_scale_sigma = scale_sigma;
        uncertainty.spread_m2 = optimisation::spread_m2(truth);
        for (int i = 0; i < kNumPositions; ++i)
            covariances.push_back(
                {1 + i, covariance_m2.block<3, 3>(3 * i, 3 * i), Eigen::Matrix3d::Zero()});
    }

    const Eigen::Vector3d& at(int i) const { return truth[static_cast<std::size_t>(i)]; }

    // Returns a draw of the path as the cameras measure it, `scale` times as long.
    Positions seen(double scale, std::mt19937& random) const {
        std::normal_distribution<double> step(0.0, kStepSigma_m);
        Positions positions;
        Eigen::Vector3d off = Eigen::Vector3d::Zero();
        for (const Eigen::Vector3d& position : truth) {
            positions.push_back(scale * position + off);
            off += Eigen::Vector3d(step(random), step(random), step(random));
        }
        return positions;
    }

    Positions truth;
    types::Trajectory trajectory;
    types::CovarianceTrack covariances;
    types::PathUncertainty uncertainty;
};

// How often the bounds that are stated after the correction held.
struct Held {
    double ate = 0.0;
    double end = 0.0;
    double mean_bound_m = 0.0;
    double mean_square_m2 = 0.0;  // of the ATE, in its expected mean square
};

// Draws true scales of the cameras and what a sensor makes of them, corrects the path, and compares
// it with the truth. `off` is an error of the calibration beyond what it states.
Held held(double cameras_sigma, double sensor_sigma, double off) {
    const Path path(cameras_sigma);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    Held held;
    for (int draw = 0; draw < kNumDraws; ++draw) {
        const double seen_scale = 1.0 + off + cameras_sigma * normal(random);
        Positions seen = path.seen(seen_scale, random);
        const auto scale = combined_scale(
            {{"sensor", {1.0 / seen_scale + sensor_sigma * normal(random), sensor_sigma}}},
            path.uncertainty.scale_sigma);
        for (Eigen::Vector3d& position : seen) position *= scale.factor;
        const double sigma = scale.sigma / scale.factor;
        const auto after = scaled(path.uncertainty, scale.factor, sigma);
        const auto covariances = with_scale_sigma(path.covariances,
                                                  offsets_from_start(path.trajectory, {}),
                                                  path.uncertainty.shared_scale_sigma,
                                                  sigma);
        const double ate = std::sqrt(synthetic::squared_ate_m2(seen, path.truth));
        const double bound_m =
            std::sqrt(optimisation::quantile_95(after.mean_square_m2, after.degrees_of_freedom));
        const double end_bound_m =
            std::sqrt(optimisation::squared_length_95(covariances.back().position_m2));
        held.ate += (ate <= bound_m ? 1.0 : 0.0) / kNumDraws;
        held.end +=
            ((seen.back() - path.truth.back()).norm() <= end_bound_m ? 1.0 : 0.0) / kNumDraws;
        held.mean_bound_m += bound_m / kNumDraws;
        held.mean_square_m2 += ate * ate / after.mean_square_m2 / kNumDraws;
    }
    return held;
}

TEST(ScaledUncertaintyTest, BoundsHoldWhereASensorKnowsMoreThanTheCameras) {
    const Held after = held(0.01, 0.001, 0.0);
    EXPECT_NEAR(after.ate, 0.95, 0.02);
    EXPECT_NEAR(after.end, 0.95, 0.02);
    EXPECT_NEAR(after.mean_square_m2, 1.0, 0.1);
    EXPECT_LT(after.mean_bound_m, 0.5 * 1.96 * 0.01 * std::sqrt(Path(0.01).uncertainty.spread_m2));
}

TEST(ScaledUncertaintyTest, BoundsHoldWhereARefutedCalibrationIsReplacedByASensorThatKnowsLess) {
    const Held after = held(0.001, 0.01, -0.08);
    EXPECT_NEAR(after.ate, 0.95, 0.03);
    EXPECT_NEAR(after.end, 0.95, 0.03);
}

TEST(ScaledUncertaintyTest, KeepsTheErrorThatIsNotDueToScale) {
    const Path path(0.01);
    const Path exact(0.0);
    const types::PathUncertainty after = scaled(path.uncertainty, 1.0, 0.0);
    EXPECT_NEAR(after.mean_square_m2, exact.uncertainty.mean_square_m2, 1e-12);
    EXPECT_NEAR(after.scale_sigma, exact.uncertainty.scale_sigma, 1e-9);
    const types::PathUncertainty same =
        scaled(path.uncertainty, 1.0, path.uncertainty.shared_scale_sigma);
    EXPECT_NEAR(same.mean_square_m2, path.uncertainty.mean_square_m2, 1e-12);
    EXPECT_NEAR(same.degrees_of_freedom, path.uncertainty.degrees_of_freedom, 1e-9);
}

// Lengths by another measurement are 5 % longer. If those are right, the true path is that much
// larger.
TEST(ScaledUncertaintyTest, WhereAnotherScaleContradictsThePathTheBoundReachesIt) {
    constexpr double kContradiction = 0.05;
    Path path(0.002);
    path.uncertainty.scale_contradiction = kContradiction;
    Positions truth = path.truth;
    for (Eigen::Vector3d& position : truth) position *= 1.0 + kContradiction;
    const double ate_m = std::sqrt(synthetic::squared_ate_m2(path.truth, truth));
    const auto covering = covering_contradiction(path.uncertainty);
    const double bound_m =
        std::sqrt(optimisation::quantile_95(covering.mean_square_m2, covering.degrees_of_freedom));
    EXPECT_GT(bound_m, ate_m);
    EXPECT_LT(bound_m, 1.05 * ate_m);
    EXPECT_GT(1.96 * lengths_sigma(path.uncertainty), kContradiction);
    EXPECT_LT(1.96 * lengths_sigma(path.uncertainty), 1.05 * kContradiction);
    EXPECT_NEAR(lengths_sigma(covering), lengths_sigma(path.uncertainty), 1e-9);
}

// A vertex of a slope, seen from a path about the origin. Of the move by another scale, the part
// along the normal counts.
TEST(ScaledUncertaintyTest, AVertexMovesWithTheScaleAwayFromTheCentreOfThePath) {
    constexpr double kScale = 1.05;
    const types::Trajectory path = {{1, Eigen::Isometry3d(Eigen::Translation3d(-1.0, 2.0, 0.5))},
                                    {2, Eigen::Isometry3d(Eigen::Translation3d(1.0, -2.0, -0.5))}};
    types::Mesh mesh;
    mesh.vertices = {{0.3F, 0.4F, -2.0F}};
    mesh.normals = {Eigen::Vector3f(0.2F, -0.1F, 1.0F).normalized()};
    mesh.sigma_m = {0.003F};
    mesh.sigma_local_m = {0.002F};
    const Eigen::Vector3f moved = static_cast<float>(kScale) * mesh.vertices[0];
    const double off_m = std::abs(mesh.normals[0].dot(moved - mesh.vertices[0]));
    const double sigma = contradiction_sigma(kScale - 1.0);

    const types::Mesh covering = with_scale_sigma(mesh, path, {}, 0.0, sigma);

    EXPECT_NEAR(covering.sigma_m[0], std::hypot(0.003, off_m / 1.959964), 1e-6);
    EXPECT_EQ(covering.sigma_local_m, mesh.sigma_local_m);
    EXPECT_EQ(covering.vertices, mesh.vertices);
    EXPECT_NEAR(with_scale_sigma(covering, path, {}, sigma, 0.0).sigma_m[0], 0.003, 1e-5);
    EXPECT_EQ(with_scale_sigma(mesh, path, {}, sigma, 0.0).sigma_m[0], mesh.sigma_local_m[0]);
}

// The same wall ahead of each path: the later segment lies 100 m farther along x.
TEST(ScaledUncertaintyTest, AVertexMovesAboutTheCentreOfItsOwnSegment) {
    constexpr double kSigma = 0.02;
    const auto at = [](std::int64_t timestamp_ns, double x) {
        return types::StampedPose{timestamp_ns,
                                  Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, 0.0))};
    };
    const types::Trajectory path = {at(1, -1.0), at(2, 1.0), at(3, 99.0), at(4, 101.0)};
    std::vector<types::TrackingSegment> segments(2);
    segments[0].intervals = {{1, 2}};
    segments[1].intervals = {{3, 4}};
    types::Mesh mesh;
    mesh.vertices = {{0.5F, 0.0F, 1.0F}, {3.0F, 0.0F, 1.0F}, {100.5F, 0, 1.0F}, {97.0F, 0, 1.0F}};
    mesh.normals.assign(4, Eigen::Vector3f::UnitX());
    mesh.sigma_m.assign(4, 0.003F);

    const types::Mesh covering = with_scale_sigma(mesh, path, segments, 0.0, kSigma);

    for (const std::size_t near_path : {0U, 2U})
        EXPECT_NEAR(covering.sigma_m[near_path], std::hypot(0.003, kSigma * 0.5), 1e-6);
    for (const std::size_t beside_path : {1U, 3U})
        EXPECT_NEAR(covering.sigma_m[beside_path], std::hypot(0.003, kSigma * 3.0), 1e-6);
    EXPECT_GT(with_scale_sigma(mesh, path, {}, 0.0, kSigma).sigma_m[0], 0.9);
}

TEST(ScaledUncertaintyTest, EachSegmentStartsItsOwnPath) {
    const Path path(0.0);
    types::Trajectory apart = path.trajectory;
    std::vector<types::Keyframe> keyframes(2);
    keyframes[0].timestamp_ns = apart[0].timestamp_ns;
    keyframes[1].timestamp_ns = apart[20].timestamp_ns;
    keyframes[1].segment = 1;
    for (std::size_t i = 20; i < apart.size(); ++i) apart[i].T_world_imu.translation().x() += 100.0;
    const auto ways =
        offsets_from_start(apart, segments_of(apart, keyframes, {apart[20].timestamp_ns}));
    EXPECT_NEAR((ways[19] - (path.at(19) - path.at(0))).norm(), 0.0, 1e-12);
    EXPECT_NEAR(ways[20].norm(), 0.0, 1e-12);
    EXPECT_NEAR((ways[30] - (path.at(30) - path.at(20))).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace divemesh::evaluation
