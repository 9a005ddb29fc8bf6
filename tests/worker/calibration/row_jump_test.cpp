#include "worker/calibration/row_jump.hpp"

#include <gtest/gtest.h>

#include "tests/worker/calibration/rough_floor_pairs.hpp"

namespace divemesh::calibration {
namespace {

constexpr int kNumPoints = 120;

types::RectifiedRig rectified() { return camera::rectified_rig(stated_rig()); }

// Returns matches of a dive in which the rig changes after some pairs.
types::StereoMatches changing(const types::Rig& before,
                              int num_before,
                              const types::Rig& after,
                              int num_after) {
    Pairs pairs(before);
    types::StereoMatches matches = pairs.matches(num_before, kNumPoints);
    pairs.go_on_with(after);
    const types::StereoMatches later = pairs.matches(num_after, kNumPoints);
    matches.insert(matches.end(), later.begin(), later.end());
    return matches;
}

TEST(RowJumpTest, FindsThePairsBetweenWhichACameraIsKnocked) {
    for (const auto& [degrees, rows_px] : {std::pair(Eigen::Vector3d(0.3, 0.0, 0.0), 2.6),
                                           std::pair(Eigen::Vector3d(-0.08, 0.0, 0.0), 0.7),
                                           std::pair(Eigen::Vector3d(0.0, 0.0, 0.4), 1.3),
                                           std::pair(Eigen::Vector3d(0.2, 0.3, -0.3), 2.0)})
        for (const int num_before : {3, 10, 20}) {
            const auto jump = find_row_jump(
                rectified(), changing(stated_rig(), num_before, knocked(degrees), 24 - num_before));

            ASSERT_TRUE(jump) << degrees.transpose() << " after " << num_before;
            EXPECT_EQ(jump->last_before, num_before - 1);
            EXPECT_EQ(jump->first_after, num_before);
            EXPECT_NEAR(jump->shift_px, rows_px, 0.25 * rows_px);
        }
}

TEST(RowJumpTest, SortsAPairToTheSideWhoseRowsItHas) {
    const types::Rig turned = knocked({0.2, 0.0, 0.1});
    const auto jump = find_row_jump(rectified(), changing(stated_rig(), 10, turned, 10));
    ASSERT_TRUE(jump);

    EXPECT_EQ(jump->is_before(Pairs(stated_rig()).matches(1, kNumPoints)), true);
    EXPECT_EQ(jump->is_before(Pairs(turned).matches(1, kNumPoints)), false);
    EXPECT_EQ(jump->is_before(Pairs(turned).matches(1, 5)), std::nullopt);
}

TEST(RowJumpTest, TellsHowFarTheRowsOfAPairHaveGone) {
    const Eigen::Vector3d degrees(0.2, 0.0, 0.3);
    const auto jump = find_row_jump(rectified(), changing(stated_rig(), 10, knocked(degrees), 10));
    ASSERT_TRUE(jump);

    for (const double share : {0.0, 0.3, 0.6, 1.0}) {
        const auto found =
            jump->share_after(Pairs(knocked(share * degrees)).matches(1, kNumPoints));
        ASSERT_TRUE(found);
        EXPECT_NEAR(*found, share, 0.1);
    }
    EXPECT_EQ(jump->share_after(Pairs(stated_rig()).matches(1, 5)), std::nullopt);
}

TEST(RowJumpTest, ARigThatStaysAsItIsDoesNotJump) {
    const types::Rig turned = knocked({0.6, 0.2, 0.5});

    EXPECT_FALSE(find_row_jump(rectified(), Pairs(stated_rig()).matches(24, kNumPoints)));
    EXPECT_FALSE(find_row_jump(rectified(), Pairs(turned).matches(24, kNumPoints)));
    EXPECT_FALSE(find_row_jump(rectified(), Pairs(turned).matches(24, kNumPoints, 0.6)));
    EXPECT_FALSE(find_row_jump(rectified(), {}));
}

TEST(RowJumpTest, RowsThatWanderFromPairToPairDoNotJump) {
    Pairs pairs(stated_rig());
    pairs.shake_rows(3.0);

    EXPECT_FALSE(find_row_jump(rectified(), pairs.matches(24, kNumPoints)));
}

TEST(RowJumpTest, ASlowBendIsNoJump) {
    Pairs pairs(stated_rig());
    types::StereoMatches matches;
    for (int i = 0; i < 24; ++i) {
        pairs.go_on_with(knocked({0.02 * i, 0.0, 0.01 * i}));
        const types::StereoMatches more = pairs.matches(1, kNumPoints);
        matches.insert(matches.end(), more.begin(), more.end());
    }

    EXPECT_FALSE(find_row_jump(rectified(), matches));
}

// With a baseline that points elsewhere, near points lie on other rows than far ones.
TEST(RowJumpTest, ComingNearerWithABentBaselineIsNoJump) {
    types::Rig bent = stated_rig();
    const double angle = 1.5 * kDeg;
    const Eigen::Isometry3d T_cam0_cam1 = bent.T_imu_cam0.inverse() * bent.T_imu_cam1;
    bent.T_imu_cam1.translation() =
        bent.T_imu_cam0 * Eigen::Vector3d(std::cos(angle) * T_cam0_cam1.translation().x(),
                                          std::sin(angle) * T_cam0_cam1.translation().x(),
                                          0.0);
    Pairs pairs(bent);
    pairs.look_at(2.5, 5.0);
    types::StereoMatches matches = pairs.matches(12, kNumPoints);
    pairs.look_at(0.6, 1.2);
    const types::StereoMatches near = pairs.matches(12, kNumPoints);
    matches.insert(matches.end(), near.begin(), near.end());

    EXPECT_FALSE(find_row_jump(rectified(), matches));
}

}  // namespace
}  // namespace divemesh::calibration
