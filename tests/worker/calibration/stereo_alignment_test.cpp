#include "worker/calibration/stereo_alignment.hpp"

#include <gtest/gtest.h>

#include "tests/worker/calibration/rough_floor_pairs.hpp"

namespace divemesh::calibration {
namespace {

using Outcome = types::RigAlignment::Outcome;

types::RigAlignment estimate(const types::StereoMatches& matches) {
    return estimate_rig_alignment(stated_rig(), camera::Rectifier(stated_rig()).rig(), matches);
}

// Returns the angle between the right camera as estimated and as it is, degrees.
double error_deg(const types::RigAlignment& found, const types::Rig& real) {
    const types::Rig rig = changed_rig(stated_rig(), found.change);
    return Eigen::AngleAxisd((rig.T_imu_cam1.inverse() * real.T_imu_cam1).linear()).angle() / kDeg;
}

TEST(StereoAlignmentTest, FindsTheRotationOfAKnockedCamera) {
    for (const Eigen::Vector3d& degrees : {Eigen::Vector3d(0.5, 0.0, 0.0),
                                           Eigen::Vector3d(-1.0, 0.0, 0.3),
                                           Eigen::Vector3d(0.06, 0.0, 0.0),
                                           Eigen::Vector3d(0.0, 0.0, 1.0),
                                           Eigen::Vector3d(0.3, 0.0, 0.2)}) {
        const types::Rig real = knocked(degrees);

        const types::RigAlignment found = estimate(Pairs(real).matches(12, 150));

        EXPECT_EQ(found.outcome, Outcome::Moved) << degrees.transpose();
        EXPECT_EQ(found.row_solver.num_failed + found.row_solver.num_still_moving, 0);
        EXPECT_LT(found.row_solver.final_cost, found.row_solver.initial_cost);
        EXPECT_LT(error_deg(found, real), 0.03) << degrees.transpose();
        EXPECT_NEAR(found.row_error_px, kNoise_px, 0.05) << degrees.transpose();
    }
}

// Returns the largest difference that two rigs make to a right pixel, of points at 2 m, px.
double pixel_difference(const types::Rig& one, const types::Rig& other) {
    double largest_px = 0.0;
    for (const double u : {20.0, 320.0, 620.0})
        for (const double v : {20.0, 240.0, 460.0}) {
            const Eigen::Vector3d p_cam0 = 2.0 * camera::unproject(one.cam0, {u, v});
            const auto first = camera::project(one.cam1, one.T_cam1_cam0() * p_cam0);
            const auto second = camera::project(other.cam1, other.T_cam1_cam0() * p_cam0);
            if (first && second) largest_px = std::max(largest_px, (*first - *second).norm());
        }
    return largest_px;
}

TEST(StereoAlignmentTest, TellsAShiftedImageFromARotation) {
    for (const double shift_px : {3.0, -5.0, 8.0}) {
        types::Rig real = stated_rig();
        real.cam1.cy_px += shift_px;

        const types::RigAlignment found = estimate(Pairs(real).matches(12, 150));

        EXPECT_EQ(found.outcome, Outcome::Moved) << shift_px;
        EXPECT_NEAR(found.change.values[types::RigChange::kCentreDown], shift_px, 0.5);
        EXPECT_LT(pixel_difference(changed_rig(stated_rig(), found.change), real), 0.25)
            << shift_px;
    }
    for (const double degrees : {0.35, -0.6, 1.0}) {
        const types::Rig real = knocked({degrees, 0.0, 0.0});

        const types::RigAlignment found = estimate(Pairs(real).matches(12, 150));

        EXPECT_EQ(found.change.values[types::RigChange::kCentreDown], 0.0) << degrees;
        EXPECT_LT(pixel_difference(changed_rig(stated_rig(), found.change), real), 0.25) << degrees;
    }
}

TEST(StereoAlignmentTest, LeavesARightCalibrationAsStated) {
    const types::RigAlignment found = estimate(Pairs(stated_rig()).matches(12, 150));

    EXPECT_EQ(found.outcome, Outcome::AsStated);
    EXPECT_LT(found.row_shift_px, 0.05);
}

TEST(StereoAlignmentTest, KeepsTheBaselineAndTheLeftCamera) {
    types::RigChange change;
    change.values << 0.01, -0.005, 0.02, 0.004, -0.003, 0.001, 0.5, -0.3;

    const types::Rig rig = changed_rig(stated_rig(), change);

    EXPECT_NEAR(rig.baseline_m(), stated_rig().baseline_m(), 1e-12);
    EXPECT_TRUE(rig.T_imu_cam0.isApprox(stated_rig().T_imu_cam0, 0.0));
    EXPECT_TRUE(changed_rig(stated_rig(), {}).T_imu_cam1.isApprox(stated_rig().T_imu_cam1, 1e-12));
}

TEST(StereoAlignmentTest, SaysNothingFromFewMatches) {
    const types::RigAlignment found = estimate(Pairs(knocked({0.5, 0.0, 0.0})).matches(2, 50));

    EXPECT_EQ(found.outcome, Outcome::Unknown);
}

TEST(StereoAlignmentTest, FindsNoPositionWherePairsDisagree) {
    Pairs pairs(stated_rig());
    pairs.shake_rows(5.0);

    EXPECT_EQ(estimate(pairs.matches(12, 150)).outcome, Outcome::Inconsistent);
}

TEST(StereoAlignmentTest, FindsNoPositionAmongWrongMatches) {
    EXPECT_EQ(estimate(Pairs(stated_rig()).matches(12, 150, 1.0)).outcome, Outcome::Inconsistent);
}

// A rig that is off by itself, and a knock in mid-dive that turns its right camera further.
TEST(StereoAlignmentTest, FindsTheTurnOfAKnockInMidDive) {
    const types::Rig rig = knocked({0.4, 0.0, 0.3});
    const types::RectifiedRig rectified = camera::rectified_rig(rig);
    for (const Eigen::Vector3d& degrees : {Eigen::Vector3d(0.3, 0.0, 0.0),
                                           Eigen::Vector3d(-0.2, 0.0, 0.4),
                                           Eigen::Vector3d(0.0, 0.0, -0.8)}) {
        types::Rig turned = rig;
        turned.T_imu_cam1.rotate(base::rotation_from_vector(kDeg * degrees));
        const auto lenses = camera::rectified_lenses(rig);
        const auto stated = camera::rectified_lenses(stated_rig());
        const types::RectifiedRig as = camera::rectified_rig(stated_rig());
        types::StereoMatches matches = Pairs(turned).matches(12, 150);
        for (types::StereoMatch& match : matches) {
            match.left_px =
                lenses[0].rectified_px(rectified, stated[0].recorded_px(as, match.left_px));
            match.right_px =
                lenses[1].rectified_px(rectified, stated[1].recorded_px(as, match.right_px));
        }

        const types::RigPart part = estimate_turn(rig, rectified, matches);

        ASSERT_TRUE(part.found);
        EXPECT_LT((part.values.head<3>() / kDeg - degrees).norm(), 0.03) << degrees.transpose();
        EXPECT_GT(part.shift_px, 1.0);
    }
}

TEST(StereoAlignmentTest, FindsNoTurnFromFewOrWrongMatches) {
    const types::RectifiedRig rectified = camera::rectified_rig(stated_rig());
    const types::Rig turned = knocked({0.3, 0.0, 0.0});

    EXPECT_FALSE(estimate_turn(stated_rig(), rectified, Pairs(turned).matches(2, 50)).found);
    EXPECT_FALSE(estimate_turn(stated_rig(), rectified, Pairs(turned).matches(12, 150, 1.0)).found);
}

}  // namespace
}  // namespace divemesh::calibration
