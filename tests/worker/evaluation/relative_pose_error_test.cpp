#include "worker/evaluation/relative_pose_error.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/paths.hpp"
#include "worker/evaluation/evaluate.hpp"

namespace divemesh::evaluation {
namespace {

// Returns a straight path with a pose every half metre, where each metre is 1 cm too long.
std::vector<PosePair> stretched(int num_poses) {
    std::vector<PosePair> poses(static_cast<std::size_t>(num_poses));
    for (std::size_t i = 0; i < poses.size(); ++i) {
        poses[i].T_reference_body.translation().x() = 0.5 * static_cast<double>(i);
        poses[i].T_world_body.translation().x() = 0.505 * static_cast<double>(i);
    }
    return poses;
}

TEST(RelativePoseError, IsWhatTheEstimateAddsOverTheLength) {
    const auto error = relative_pose_error(stretched(101), {.delta_m = 1.0});
    EXPECT_EQ(error.num_pairs, 49);  // the first pair begins where one metre is reached
    EXPECT_NEAR(error.translation_rmse_m, 0.01, 1e-12);
    EXPECT_NEAR(error.rotation_rmse_deg, 0.0, 1e-9);
}

TEST(RelativePoseError, AllPairsBeginAtEveryPose) {
    const auto error = relative_pose_error(
        stretched(101), {.delta_m = 1.0, .pairs = RelativePoseOptions::Pairs::All});
    EXPECT_EQ(error.num_pairs, 99);
    EXPECT_NEAR(error.translation_mean_m, 0.01, 1e-12);
}

TEST(RelativePoseError, APathShorterThanTwoLengthsHasNone) {
    EXPECT_EQ(relative_pose_error(stretched(3), {.delta_m = 1.0}).num_pairs, 0);
    EXPECT_EQ(relative_pose_error({}, {.delta_m = 1.0}).num_pairs, 0);
}

TEST(RelativePoseError, EqualsThePublishedMetricsOfEvo) {
    const auto folder = shared_data("evo");
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
    const auto metrics = evaluate_trajectory(
        folder / "KITTI_00_ORB.txt", folder / "KITTI_00_gt.txt", {.relative = {.delta_m = 10.0}});
    EXPECT_NEAR(metrics["ate_rmse_m"].get<double>(), 1.3034497145650266, 5e-7);
    EXPECT_NEAR(metrics["relative_pose"]["translation_rmse_m"].get<double>(), 0.226261, 5e-7);
}

}  // namespace
}  // namespace divemesh::evaluation
