#include "worker/loops/pose_graph.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/synthetic/pose_near.hpp"
#include "tests/worker/loops/laps.hpp"

namespace divemesh::loops {
namespace {

TEST(PoseGraphTest, AnEvenYawErrorGoesAwayAlongTheWholeLap) {
    Laps laps(0.004);  // 14 degrees over the lap
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    const std::vector<Loop> loops = {laps.loop(0, 60), laps.loop(3, 63), laps.loop(6, 66)};
    const double before_m =
        (laps.keyframes[45].T_world_cam.translation() - laps.truth[45].translation()).norm();
    ASSERT_GT(before_m, 0.2);

    optimise_pose_graph(loops, drift, laps.keyframes, laps.landmarks);

    for (std::size_t k = 0; k < laps.keyframes.size(); ++k)
        EXPECT_THAT(laps.keyframes[k].T_world_cam,
                    synthetic::IsPoseWithin(laps.truth[k], 2.0, 0.06))
            << "keyframe " << k;
}

TEST(PoseGraphTest, LandmarksGoWithTheirKeyframes) {
    Laps laps(0.004);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    optimise_pose_graph({laps.loop(0, 60)}, drift, laps.keyframes, laps.landmarks);
    ASSERT_FALSE(laps.landmarks.empty());
    for (const types::Landmark& landmark : laps.landmarks) {
        const auto anchor = static_cast<std::size_t>(landmark.observations.front().keyframe);
        const Eigen::Vector3d p_cam =
            laps.keyframes[anchor].T_world_cam.inverse() * landmark.p_world;
        EXPECT_NEAR(p_cam.z(), 2.0, 1e-9);
        EXPECT_NEAR(p_cam.y(), 0.0, 1e-9);
    }
}

TEST(PoseGraphTest, SaysThatItStoppedAtItsLimit) {
    Laps laps(0.02);  // more than a whole turn over the lap
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    const std::vector<Loop> loops = {laps.loop(0, 60), laps.loop(3, 63), laps.loop(6, 66)};
    Laps again = laps;

    const types::SolverOutcome stopped =
        optimise_pose_graph(loops, drift, laps.keyframes, laps.landmarks, 2);
    EXPECT_EQ(stopped.termination, types::SolverOutcome::Termination::StoppedAtLimit);
    EXPECT_EQ(stopped.num_iterations, 2);
    EXPECT_GT(stopped.last_decrease, 0.01) << "the cost is still falling";

    const types::SolverOutcome converged =
        optimise_pose_graph(loops, drift, again.keyframes, again.landmarks);
    EXPECT_EQ(converged.termination, types::SolverOutcome::Termination::Converged);
    EXPECT_LT(converged.final_cost, stopped.final_cost);
    EXPECT_DOUBLE_EQ(converged.initial_cost, stopped.initial_cost);
}

TEST(PoseGraphTest, AFailureMovesNothing) {
    Laps laps(0.004);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    Loop loop = laps.loop(0, 60);
    loop.T_from_to.translation().x() = std::numeric_limits<double>::quiet_NaN();
    const Laps before = laps;
    EXPECT_TRUE(optimise_pose_graph({loop}, drift, laps.keyframes, laps.landmarks).failed());
    for (std::size_t k = 0; k < laps.keyframes.size(); ++k)
        EXPECT_EQ(laps.keyframes[k].T_world_cam.matrix(), before.keyframes[k].T_world_cam.matrix());
    for (std::size_t i = 0; i < laps.landmarks.size(); ++i)
        EXPECT_EQ(laps.landmarks[i].p_world, before.landmarks[i].p_world);
}

}  // namespace
}  // namespace divemesh::loops
