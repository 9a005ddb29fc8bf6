#include "worker/odometry/support.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/synthetic/stereo_world.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::size_t kNumPrevious = 200;

// A motion with so many inliers, spread over the image, that moved by 40 px.
Registration motion_of(std::size_t num_inliers, std::size_t num_outliers = 0) {
    const types::RectifiedRig rig = synthetic::rig();
    Registration motion;
    motion.found = true;
    motion.num_pairs = num_inliers + num_outliers;
    motion.T_current_previous.translation().x() = 40.0 * 2.0 / rig.focal_px;
    for (std::size_t i = 0; i < num_inliers; ++i) {
        PointPair pair;
        pair.p_previous = rig.point_cam(20.0 + static_cast<double>(i * 97 % 560),
                                        20.0 + static_cast<double>(i * 61 % 440),
                                        2.0);
        pair.current_px = types::project_px(rig, motion.T_current_previous * pair.p_previous);
        motion.inliers.push_back(pair);
    }
    return motion;
}

bool supported(const Registration& motion, const std::optional<Eigen::Isometry3d>& expected) {
    return well_supported(synthetic::rig(), motion, kNumPrevious, expected);
}

TEST(SupportTest, AnUnexpectedMotionNeedsAGoodPartOfTheFeatures) {
    const Eigen::Isometry3d at_rest = Eigen::Isometry3d::Identity();
    EXPECT_TRUE(supported(motion_of(100), at_rest));
    EXPECT_FALSE(supported(motion_of(50), at_rest));
}

TEST(SupportTest, AFewFeaturesConfirmThePrediction) {
    const Registration motion = motion_of(15);
    EXPECT_TRUE(supported(motion, motion.T_current_previous));
    EXPECT_FALSE(supported(motion_of(5), motion.T_current_previous));
}

// The same motion of the same scene moves three times as many pixels of an image three times as
// wide.
TEST(SupportTest, NearThePredictionIsAShareOfTheWidthInWideImages) {
    for (const int width_px : {320, 640, 1920}) {
        const types::RectifiedRig rig =
            synthetic::ideal_rig(width_px, width_px * 3 / 4, 0.78 * width_px);
        PointPair pair;
        pair.p_previous = Eigen::Vector3d(0.1, -0.2, 2.0);
        pair.current_px = types::project_px(rig, pair.p_previous);
        const auto is_near = [&](double error_px) {
            Eigen::Isometry3d expected = Eigen::Isometry3d::Identity();
            expected.translation().x() = error_px * 2.0 / rig.focal_px;
            return is_near_prediction(rig, {pair}, expected);
        };
        const double times_wider = std::max(1.0, width_px / 640.0);
        EXPECT_TRUE(is_near(3.9 * times_wider)) << width_px;
        EXPECT_FALSE(is_near(4.1 * times_wider)) << width_px;
    }
}

// After two seconds at constant velocity: one brick in ten is taken for its neighbour.
TEST(SupportTest, FewFeaturesConfirmNoMotionThatNothingPredicts) {
    const Registration motion = motion_of(20);
    EXPECT_FALSE(supported(motion, std::nullopt));
    EXPECT_TRUE(supported(motion_of(100), std::nullopt));
    const types::RectifiedRig rig = synthetic::rig();
    EXPECT_TRUE(explained_by_chance(rig, motion, kNumPrevious, std::nullopt));
    EXPECT_FALSE(explained_by_chance(rig, motion, kNumPrevious, motion.T_current_previous));
    EXPECT_FALSE(explained_by_chance(rig, motion_of(60), kNumPrevious, std::nullopt));
}

TEST(SupportTest, ChanceExplainsFewPairsThatAgreeOnAnUnexpectedMotion) {
    const types::RectifiedRig rig = synthetic::rig();
    const Eigen::Isometry3d at_rest = Eigen::Isometry3d::Identity();
    EXPECT_TRUE(explained_by_chance(rig, motion_of(9), 20, at_rest));
    EXPECT_TRUE(explained_by_chance(rig, motion_of(20, 30), 60, at_rest));
    EXPECT_TRUE(explained_by_chance(rig, motion_of(20), 500, at_rest));
    EXPECT_FALSE(explained_by_chance(rig, motion_of(20), 60, at_rest));
    EXPECT_FALSE(explained_by_chance(rig, motion_of(9), 100, motion_of(9).T_current_previous));
    EXPECT_TRUE(explained_by_chance(rig, motion_of(9), 500, motion_of(9).T_current_previous));
}

TEST(SupportTest, PairsThatDisagreeOrFeaturesInOneCornerDoNotSupport) {
    const Registration motion = motion_of(100, 100);
    EXPECT_FALSE(supported(motion, motion.T_current_previous));
    Registration corner = motion_of(100);
    for (PointPair& pair : corner.inliers) pair.current_px.head<2>() *= 0.2;
    EXPECT_FALSE(supported(corner, Eigen::Isometry3d::Identity()));
}

}  // namespace
}  // namespace divemesh::odometry
