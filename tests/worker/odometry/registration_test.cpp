#include <gtest/gtest.h>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/odometry/register_with_rotation.hpp"
#include "worker/odometry/sigma_of_motion.hpp"
#include "worker/optimisation/refine_pose_by_ceres.hpp"

namespace divemesh::odometry {
namespace {

using synthetic::IsPoseWithin;

Eigen::Isometry3d true_motion() {
    return synthetic::T_world_cam(11).inverse() * synthetic::T_world_cam(10);
}

PointPairs pairs(synthetic::World& world, double noise_px) {
    const types::Features previous = world.see(synthetic::T_world_cam(10), 10, noise_px);
    const types::Features current = world.see(synthetic::T_world_cam(11), 11, noise_px);
    return with_depth_at_both_times(synthetic::rig(), previous, current);
}

TEST(WithDepthAtBothTimesTest, KeepsWhatHasDepthTwice) {
    const types::Features previous = {{1, {10, 10}, 20.0}, {2, {20, 10}, 0.0}, {4, {40, 10}, 20.0}};
    const types::Features current = {
        {1, {11, 10}, 21.0}, {2, {21, 10}, 20.0}, {3, {30, 10}, 20.0}, {4, {41, 10}, 0.0}};

    const PointPairs kept = with_depth_at_both_times(synthetic::rig(), previous, current);

    ASSERT_EQ(kept.size(), 1U);
    EXPECT_EQ(kept[0].id, 1);
    EXPECT_NEAR(kept[0].p_current.z(), 500.0 * 0.12 / 21.0, 1e-9);
}

TEST(RegisterPointsTest, FindsTheMotionAmongThirtyPercentFish) {
    synthetic::World world(1.0, 0.3, 3);
    const PointPairs all = pairs(world, 0.2);

    const Registration motion = register_points(synthetic::rig(), all, 2.0, 1);

    ASSERT_TRUE(motion.found);
    EXPECT_THAT(motion.T_current_previous, IsPoseWithin(true_motion(), 0.3, 0.01));
    EXPECT_NEAR(motion.scale, 1.0, 0.02);
    std::size_t num_still = 0;
    for (const PointPair& pair : all) num_still += world.is_fish(pair.id) ? 0 : 1;
    std::size_t num_inlier_fish = 0;
    for (const PointPair& pair : motion.inliers) num_inlier_fish += world.is_fish(pair.id) ? 1 : 0;
    EXPECT_GT(motion.inliers.size(), num_still * 9 / 10);
    EXPECT_LT(num_inlier_fish, motion.inliers.size() / 20);
}

TEST(RegisterPointsTest, GivesTheSameForTheSameSeed) {
    synthetic::World world(1.0, 0.3, 4);
    const PointPairs all = pairs(world, 0.3);
    const Registration once = register_points(synthetic::rig(), all, 2.0, 5);
    const Registration again = register_points(synthetic::rig(), all, 2.0, 5);
    EXPECT_EQ(once.T_current_previous.matrix(), again.T_current_previous.matrix());
}

TEST(RegisterPointsTest, FindsNothingWhereNothingAgrees) {
    synthetic::World world(1.0, 0.0, 4);
    PointPairs all = pairs(world, 0.0);
    for (PointPair& pair : all) {
        pair.current_px.head<2>() =
            Eigen::Vector2d(world.uniform(0.0, 640.0), world.uniform(0.0, 480.0));
        pair.p_current = synthetic::rig().point_cam(
            pair.current_px.x(), pair.current_px.y(), world.uniform(1.0, 3.0));
        pair.current_px.z() = synthetic::rig().disparity_px(pair.p_current.z());
    }
    EXPECT_FALSE(register_points(synthetic::rig(), all, 2.0, 1).found);
    EXPECT_FALSE(register_points(synthetic::rig(), {}, 2.0, 1).found);
}

TEST(RegisterWithTurnTest, FindsTheMotionAmongSixtyPercentFish) {
    synthetic::World world(1.0, 0.6, 3);
    const PointPairs all = pairs(world, 0.2);
    const types::KnownRotation rotation{Eigen::Quaterniond(true_motion().linear()), 1e-3};

    const Registration motion = register_with_rotation(
        synthetic::rig(), all, rotation, Eigen::Isometry3d::Identity(), 2.0, 1);

    ASSERT_TRUE(motion.found);
    EXPECT_THAT(motion.T_current_previous, IsPoseWithin(true_motion(), 0.1, 0.004));
    std::size_t num_fish = 0;
    for (const PointPair& pair : motion.inliers) num_fish += world.is_fish(pair.id) ? 1 : 0;
    EXPECT_LT(num_fish, motion.inliers.size() / 15);
}

TEST(RegisterWithTurnTest, FallsBackToHornWhenTheTurnIsUnknownOrWrong) {
    synthetic::World world(1.0, 0.3, 3);
    const PointPairs all = pairs(world, 0.2);
    const types::KnownRotation wrong{
        Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ())), 1e-3};
    for (const auto& rotation : {std::optional<types::KnownRotation>(), std::optional(wrong)}) {
        const Registration motion = register_with_rotation(
            synthetic::rig(), all, rotation, Eigen::Isometry3d::Identity(), 2.0, 1);
        ASSERT_TRUE(motion.found);
        EXPECT_THAT(motion.T_current_previous, IsPoseWithin(true_motion(), 0.06, 0.003));
    }
}

TEST(RegisterWithTurnTest, TellsWhenThePairsLeaveTheMotionOpen) {
    synthetic::World world(1.0, 0.0, 8);
    const types::RectifiedRig rig = synthetic::rig();
    PointPairs line;  // a chain hanging in open water
    for (int i = 0; i < 30; ++i) {
        const Eigen::Vector3d p_previous(0.3, -0.6 + 0.04 * i, 2.0);
        const auto measured = [&](const Eigen::Vector3d& p_cam) {
            const Eigen::Vector3d m =
                types::project_px(rig, p_cam) +
                0.1 * Eigen::Vector3d(world.normal(), world.normal(), world.normal());
            return types::Feature{i, m.head<2>(), m.z()};
        };
        const types::Features previous = {measured(p_previous)};
        const types::Features current = {measured(true_motion() * p_previous)};
        const PointPair pair = with_depth_at_both_times(rig, previous, current)[0];
        line.push_back(pair);
    }
    const types::KnownRotation rotation{Eigen::Quaterniond(true_motion().linear()), 1e-3};

    const Registration blind =
        register_with_rotation(rig, line, std::nullopt, true_motion(), 2.0, 1);
    const Registration known = register_with_rotation(rig, line, rotation, true_motion(), 2.0, 1);

    EXPECT_TRUE(blind.degenerate);
    EXPECT_FALSE(blind.found);
    EXPECT_FALSE(known.degenerate);
    EXPECT_TRUE(known.found);
}

TEST(PredictOrientationTest, TakesTheInertialTurnAndTheTranslationThatGoesWithIt) {
    synthetic::World world(1.0, 0.0, 5);
    const Registration motion = register_points(synthetic::rig(), pairs(world, 0.2), 2.0, 1);
    const types::KnownRotation known{Eigen::Quaterniond(true_motion().linear()), 1e-4};

    const MotionGuess guess = predict_orientation(known, motion);

    EXPECT_THAT(guess.T_current_previous, IsPoseWithin(true_motion(), 1e-6, 0.003));
    EXPECT_LT(guess.disagreement_rad, 0.01);
}

TEST(RefinePoseTest, ComesNearerToTheTruthThanRansac) {
    synthetic::World world(1.0, 0.3, 6);
    const Registration motion = register_points(synthetic::rig(), pairs(world, 0.2), 2.0, 1);

    const Eigen::Isometry3d refined =
        refine_pose(synthetic::rig(), motion.inliers, predict_orientation(std::nullopt, motion))
            .T_current_previous;

    EXPECT_THAT(refined, IsPoseWithin(true_motion(), 0.06, 0.0025));
}

TEST(RefinePoseTest, FindsWhatCeresFinds) {
    for (const double noise_px : {0.0, 0.25}) {
        synthetic::World world(1.0, 0.1, 7);
        const PointPairs all = pairs(world, noise_px);
        const Registration motion = register_points(synthetic::rig(), all, 2.0, 1);
        const types::KnownRotation known{Eigen::Quaterniond(true_motion().linear()), 1e-3};
        for (const auto& rotation : {std::optional<types::KnownRotation>(), std::optional(known)}) {
            const MotionGuess guess = predict_orientation(rotation, motion);
            const RefinedPose own = refine_pose(synthetic::rig(), motion.inliers, guess);
            const RefinedPose theirs =
                optimisation::refine_pose_by_ceres(synthetic::rig(), motion.inliers, guess);
            EXPECT_THAT(own.T_current_previous,
                        IsPoseWithin(theirs.T_current_previous, 0.01, 5e-4));
            for (const RefinedPose& pose : {own, theirs}) {
                EXPECT_EQ(pose.outcome.termination, types::SolverOutcome::Termination::Converged);
                EXPECT_GT(pose.outcome.num_iterations, 0);
                EXPECT_LE(pose.outcome.final_cost, pose.outcome.initial_cost);
            }
        }
    }
}

TEST(RefinePoseTest, GainsByAKnownRotation) {
    synthetic::World world(1.0, 0.0, 6);
    const Registration motion = register_points(synthetic::rig(), pairs(world, 0.2), 2.0, 1);
    const types::KnownRotation known{Eigen::Quaterniond(true_motion().linear()), 5e-5};

    const Eigen::Isometry3d refined =
        refine_pose(synthetic::rig(), motion.inliers, predict_orientation(known, motion))
            .T_current_previous;

    EXPECT_THAT(refined, IsPoseWithin(true_motion(), 0.01, 0.001));
}

TEST(SigmaOfMotionTest, IsTheSpreadOfTheErrorsOfFortyMotions) {
    double moved_m2 = 0.0;
    double stated_m2 = 0.0;
    double turned_rad2 = 0.0;
    double stated_rad2 = 0.0;
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        synthetic::World world(1.0, 0.0, seed);
        const double noise_px = types::kFeatureSigma_px.x();
        const Registration motion =
            register_points(synthetic::rig(), pairs(world, noise_px), 2.0, 1);
        const MotionGuess guess{
            refine_pose(synthetic::rig(), motion.inliers, predict_orientation(std::nullopt, motion))
                .T_current_previous,
            std::nullopt,
            0.0};
        const types::MotionSigma sigma = sigma_of_motion(synthetic::rig(), motion, guess, 0.1);
        moved_m2 +=
            (guess.T_current_previous.translation() - true_motion().translation()).squaredNorm() /
            3.0;
        stated_m2 += sigma.position_m * sigma.position_m;
        const double angle_rad = Eigen::AngleAxisd(guess.T_current_previous.linear() *
                                                   true_motion().linear().transpose())
                                     .angle();
        turned_rad2 += angle_rad * angle_rad / 3.0;
        stated_rad2 += sigma.rotation_rad * sigma.rotation_rad;
    }
    EXPECT_NEAR(moved_m2 / stated_m2, 1.0, 0.5);
    EXPECT_NEAR(turned_rad2 / stated_rad2, 1.0, 0.5);
}

TEST(SigmaOfMotionTest, GrowsWithTheTimeInWhichNothingWasMeasured) {
    const types::MotionSigma brief = sigma_of_motion(synthetic::rig(), {}, {}, 0.1);
    const types::MotionSigma longer = sigma_of_motion(synthetic::rig(), {}, {}, 0.4);
    EXPECT_NEAR(longer.position_m, 2.0 * brief.position_m, 1e-12);
    EXPECT_NEAR(longer.rotation_rad, 2.0 * brief.rotation_rad, 1e-12);
    MotionGuess turned;
    turned.rotation = types::KnownRotation{Eigen::Quaterniond::Identity(), 1e-4};
    EXPECT_EQ(sigma_of_motion(synthetic::rig(), {}, turned, 0.4).rotation_rad, 1e-4);
}

TEST(SigmaOfMotionTest, AMotionThatThePairsDoNotDetermineCountsAsUnmeasured) {
    Registration motion;
    motion.found = true;
    synthetic::World world(1.0, 0.0, 1);
    motion.inliers = pairs(world, 0.2);
    MotionGuess behind;
    behind.T_current_previous.translation().z() = -100.0;
    const types::MotionSigma none = sigma_of_motion(synthetic::rig(), {}, {}, 0.1);
    EXPECT_EQ(sigma_of_motion(synthetic::rig(), motion, behind, 0.1).position_m, none.position_m);
    motion.inliers.clear();
    EXPECT_EQ(sigma_of_motion(synthetic::rig(), motion, {}, 0.1).position_m, none.position_m);
}

TEST(RefinePoseTest, GivesTheGuessAndSaysThatItFailedWhereAPointWouldLieBehindTheCamera) {
    synthetic::World world(1.0, 0.0, 6);
    MotionGuess guess;
    guess.T_current_previous.translation().z() = -100.0;

    const RefinedPose refined = refine_pose(synthetic::rig(), pairs(world, 0.2), guess);

    EXPECT_TRUE(refined.outcome.failed());
    EXPECT_FALSE(refined.outcome.message.empty());
    EXPECT_EQ(refined.T_current_previous.matrix(), guess.T_current_previous.matrix());
}

}  // namespace
}  // namespace divemesh::odometry
