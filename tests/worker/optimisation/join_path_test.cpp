#include "worker/optimisation/join_path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "worker/base/hashed_random.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/align_heading.hpp"

namespace divemesh::optimisation {
namespace {

constexpr std::size_t kAnchors = 40;
constexpr double kStep_m = 5.0;
constexpr double kYawWalk_rad = 0.012;  // per step
constexpr double kStepNoise_m = 0.01;   // per step and axis
constexpr double kHeading_rad = 2.1;    // of the true path's world in the site
const Eigen::Vector3d kPlace_m(120.0, -40.0, 7.0);

std::int64_t time_of(std::size_t anchor) {
    return static_cast<std::int64_t>(anchor) * 20'000'000'000;
}

// A path of four lines of 50 m that drifts in yaw and position, its truth, and what is known of it.
struct DriftingPath {
    std::vector<Eigen::Isometry3d> estimated;
    std::vector<Eigen::Isometry3d> truth;
    types::PathPrior prior;
    types::Breaks breaks_ns;

    AnchoredPath path() const { return {prior.timestamps_ns, estimated, breaks_ns}; }
};

double heading_of(std::size_t step) {
    const std::size_t line = step / 10;
    return line % 2 == 0 ? 0.0 : std::numbers::pi;
}

// `jump_m` and `jump_rad` are how far the second half lies off: their sigma is `jump_sigma_m` and
// 0.3 rad.
DriftingPath drifting_path(std::uint64_t seed, double jump_sigma_m = 0.0) {
    base::RandomRow random(seed);
    DriftingPath made;
    const auto num = static_cast<Eigen::Index>(kAnchors);
    // Columns: yaw, then x, y, z of the error of each step.
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(6 * num, 4 * num);
    Eigen::VectorXd sigmas = Eigen::VectorXd::Zero(4 * num);
    Eigen::Isometry3d T_estimated = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_true = Eigen::Isometry3d::Identity();
    for (std::size_t i = 0; i < kAnchors; ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        if (i > 0) {
            const bool jumps = jump_sigma_m > 0.0 && i == kAnchors / 2;
            sigmas[4 * k] = jumps ? 0.3 : kYawWalk_rad;
            sigmas.segment<3>(4 * k + 1).setConstant(jumps ? jump_sigma_m : kStepNoise_m);
            if (jumps) made.breaks_ns.push_back(time_of(i));
            A.middleRows<6>(6 * k) = A.middleRows<6>(6 * k - 6);
            Eigen::Vector3d step(kStep_m * std::cos(heading_of(i)), 0.0, 0.0);
            step.y() = i % 10 == 0 ? kStep_m : 0.0;
            // The yaw before the step rotates it.
            for (Eigen::Index c = 4; c < 4 * k; c += 4)
                A.block<3, 1>(6 * k, c) += Eigen::Vector3d::UnitZ().cross(step);
            A.block<3, 3>(6 * k, 4 * k + 1).setIdentity();
            A(6 * k + 5, 4 * k) = 1.0;
            T_estimated.translation() += step;
            const Eigen::Vector3d error(sigmas[4 * k + 1] * random.gaussian(),
                                        sigmas[4 * k + 1] * random.gaussian(),
                                        sigmas[4 * k + 1] * random.gaussian());
            T_true.translation() += T_true.linear() * step + error;
            T_true.linear() =
                Eigen::AngleAxisd(sigmas[4 * k] * random.gaussian(), Eigen::Vector3d::UnitZ()) *
                T_true.linear();
        }
        made.estimated.push_back(T_estimated);
        made.truth.push_back(T_true);
        made.prior.timestamps_ns.push_back(time_of(i));
        made.prior.apart_m.push_back(0.0);
    }
    made.prior.drift = A * sigmas.cwiseAbs2().asDiagonal() * A.transpose();
    made.prior.shared = Eigen::MatrixXd::Zero(6 * num, 1);
    return made;
}

Eigen::Isometry3d true_site() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(kHeading_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T.translation() = kPlace_m;
    return T;
}

// Returns a position at every anchor, `outliers` of them 30 m off.
std::vector<OutsidePoint> positions(const DriftingPath& made,
                                    double sigma_m,
                                    double outliers,
                                    std::uint64_t seed) {
    base::RandomRow random(seed + 1000);
    std::vector<OutsidePoint> points;
    for (std::size_t i = 0; i < kAnchors; ++i) {
        const Eigen::Vector3d noise(
            sigma_m * random.gaussian(), sigma_m * random.gaussian(), sigma_m * random.gaussian());
        Eigen::Vector3d p_site = true_site() * made.truth[i].translation() + noise;
        if (random.uniform(0.0, 1.0) < outliers) p_site.x() += 30.0;
        points.push_back({time_of(i), made.estimated[i].translation(), p_site, sigma_m, sigma_m});
    }
    return points;
}

// Returns the error of the last position, first poses aligned.
Eigen::Vector3d end_error(const DriftingPath& made, const JoinedPath& joined) {
    return joined.T_new_old.front().inverse() * joined.T_new_old.back() *
               made.estimated.back().translation() -
           made.truth.back().translation();
}

JoinedPath join(const DriftingPath& made, const std::vector<OutsidePoint>& points) {
    return join_path(
        made.path(), made.prior, points, {}, align_heading(points), {.offset_sigmas_m = {0.0}});
}

TEST(JoinPathTest, PositionsBoundTheDriftAndTheStatedSigmaHolds) {
    double squares_without = 0.0;
    double squares_with = 0.0;
    double squares_sigmas = 0.0;
    double squares_heading = 0.0;
    constexpr int kDraws = 30;
    for (int seed = 1; seed <= kDraws; ++seed) {
        const DriftingPath made = drifting_path(static_cast<std::uint64_t>(seed));
        const JoinedPath joined =
            join(made, positions(made, 0.4, 0.0, static_cast<std::uint64_t>(seed)));
        ASSERT_TRUE(joined.converged) << "seed " << seed;
        const Eigen::Vector3d error = end_error(made, joined);
        squares_without +=
            (made.estimated.back().translation() - made.truth.back().translation()).squaredNorm();
        squares_with += error.squaredNorm();
        const Eigen::Matrix3d covariance_m2 =
            joined.covariance.block<3, 3>(6 * (kAnchors - 1), 6 * (kAnchors - 1));
        squares_sigmas += error.dot(covariance_m2.ldlt().solve(error));
        const Eigen::AngleAxisd turned(true_site().linear().transpose() *
                                       joined.T_site_world.linear());
        squares_heading += turned.angle() * turned.angle() / joined.site_covariance(2, 2);
    }
    EXPECT_LT(std::sqrt(squares_with / kDraws), 0.5 * std::sqrt(squares_without / kDraws));
    // Chi-square with 3 and 1 degrees of freedom: means over 30 draws, three sigmas.
    EXPECT_NEAR(squares_sigmas / kDraws, 3.0, 1.35);
    EXPECT_LT(squares_heading / kDraws, 1.0 + 3.0 * std::sqrt(2.0 / kDraws));
}

TEST(JoinPathTest, OutliersHardlyMoveThePath) {
    double squares = 0.0;
    double squares_clean = 0.0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const DriftingPath made = drifting_path(seed);
        squares +=
            std::pow(end_error(made, join(made, positions(made, 0.3, 0.25, seed))).norm(), 2);
        squares_clean +=
            std::pow(end_error(made, join(made, positions(made, 0.3, 0.0, seed))).norm(), 2);
    }
    EXPECT_LT(std::sqrt(squares), 1.6 * std::sqrt(squares_clean));
}

TEST(JoinPathTest, PartsOfAPathThatNothingTiesAreFound) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const DriftingPath made = drifting_path(seed, 10.0);
        const JoinedPath joined = join(made, positions(made, 0.3, 0.1, seed));
        const Eigen::Vector3d error = end_error(made, joined);
        EXPECT_LT(error.norm(), 1.2) << "seed " << seed;
        // The second part is turned as a rigid body: its last line keeps its length.
        const double length_m = (joined.T_new_old[39] * made.estimated[39].translation() -
                                 joined.T_new_old[31] * made.estimated[31].translation())
                                    .norm();
        EXPECT_NEAR(length_m, 40.0, 0.2) << "seed " << seed;
    }
}

TEST(JoinPathTest, AMotionAcrossAGapPlacesTheSecondPart) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        DriftingPath made = drifting_path(seed, 10.0);
        constexpr std::size_t kLast = kAnchors / 2 - 1;
        const OutsideMotion motion{
            kLast,
            made.truth[kLast].linear().transpose() *
                (made.truth[kLast + 1].translation() - made.truth[kLast].translation()),
            0.02};
        const JoinedPath joined =
            join_path(made.path(), made.prior, {}, {motion}, Eigen::Isometry3d::Identity(), {});
        ASSERT_TRUE(joined.converged);
        const Eigen::Vector3d found =
            joined.T_new_old[kLast].linear().transpose() *
            (joined.T_new_old[kLast + 1] * made.estimated[kLast + 1].translation() -
             joined.T_new_old[kLast] * made.estimated[kLast].translation());
        EXPECT_LT(
            (found - made.truth[kLast].linear().transpose() *
                         (made.truth[kLast + 1].translation() - made.truth[kLast].translation()))
                .norm(),
            0.06);
    }
}

TEST(JoinPathTest, AFreeScaleIsFound) {
    DriftingPath made = drifting_path(3);
    for (Eigen::Isometry3d& pose : made.truth) pose.translation() *= 1.03;
    const std::vector<OutsidePoint> points = positions(made, 0.1, 0.1, 3);
    const JoinedPath joined =
        join_path(made.path(),
                  made.prior,
                  points,
                  {},
                  align_heading(points),
                  {.scale_sigma = 0.1, .calibration_is_exact = true, .offset_sigmas_m = {0.0}});
    EXPECT_NEAR(joined.scale_error, 0.03, 3.0 * joined.scale_error_sigma);
    EXPECT_LT(joined.scale_error_sigma, 0.006);
}

TEST(JoinPathTest, TellsWhetherThePathDriftedMoreThanItsPriorSays) {
    double ratio = 0.0;
    double ratio_too_small = 0.0;
    constexpr int kDraws = 15;
    for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
        DriftingPath made = drifting_path(seed);
        const std::vector<OutsidePoint> points = positions(made, 0.3, 0.0, seed);
        const JoinedPath right = join(made, points);
        ratio += right.moved_squares / right.num_determined / kDraws;
        made.prior.drift /= 16.0;
        const JoinedPath wrong = join(made, points);
        ratio_too_small += wrong.moved_squares / wrong.num_determined / kDraws;
    }
    EXPECT_NEAR(ratio, 1.0, 0.4);
    EXPECT_GT(ratio_too_small, 3.0);
}

TEST(JoinPathTest, AnOffsetOfAllPositionsIsNotTakenForCertain) {
    const DriftingPath made = drifting_path(5);
    const std::vector<OutsidePoint> points = positions(made, 0.3, 0.0, 5);
    const JoinedPath joined = join_path(
        made.path(), made.prior, points, {}, align_heading(points), {.offset_sigmas_m = {2.0}});
    EXPECT_GT(std::sqrt(joined.site_covariance(3, 3)), 2.0);
    EXPECT_GT(std::sqrt(joined.site_covariance(4, 4)), 2.0);
}

}  // namespace
}  // namespace divemesh::optimisation
