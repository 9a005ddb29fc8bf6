#include "worker/evaluation/scaled_uncertainty.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/synthetic/trajectory_error.hpp"
#include "worker/evaluation/combined_scale.hpp"
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
                                                  offsets_from_start(path.trajectory, {}, {}),
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

TEST(ScaledUncertaintyTest, EachSegmentStartsItsOwnPath) {
    const Path path(0.0);
    types::Trajectory apart = path.trajectory;
    std::vector<types::Keyframe> keyframes(2);
    keyframes[0].timestamp_ns = apart[0].timestamp_ns;
    keyframes[1].timestamp_ns = apart[20].timestamp_ns;
    keyframes[1].segment = 1;
    for (std::size_t i = 20; i < apart.size(); ++i) apart[i].T_world_imu.translation().x() += 100.0;
    const auto ways = offsets_from_start(apart, keyframes, {apart[20].timestamp_ns});
    EXPECT_NEAR((ways[19] - (path.at(19) - path.at(0))).norm(), 0.0, 1e-12);
    EXPECT_NEAR(ways[20].norm(), 0.0, 1e-12);
    EXPECT_NEAR((ways[30] - (path.at(30) - path.at(20))).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace divemesh::evaluation
