#include "tests/bench/sift_baseline.hpp"

#include <gtest/gtest.h>

#include "tests/bench/small_dive.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"

namespace divemesh::bench {
namespace {

TEST(SiftBaselineTest, FollowsADiveInClearWaterToACentimetre) {
    const TemporaryFolder folder;
    render_small_dive(folder / "dive");
    const auto dive = dive::Dive::open(folder / "dive", folder / "scratch");
    const SiftPath path = sift_path(*dive);
    EXPECT_EQ(path.num_frames, dive->num_frames());
    EXPECT_EQ(path.num_links, path.num_frames - 1);
    ASSERT_EQ(path.chains.size(), 1U);
    const auto error =
        evaluation::trajectory_error(path.longest()->T_first_cam0,
                                     dive->ground_truth(),
                                     {.T_referencebody_estimatebody = dive->rig().T_imu_cam0});
    EXPECT_GT(error.path_length_m, 1.0);
    EXPECT_LT(error.ate_rmse_m, 0.015);
    EXPECT_NEAR(error.sim3_scale, 1.0, 0.03);
}

}  // namespace
}  // namespace divemesh::bench
