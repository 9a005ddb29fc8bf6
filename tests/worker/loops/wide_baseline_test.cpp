#include <gtest/gtest.h>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/sea_floor.hpp"
#include "worker/loops/register_wide_baseline.hpp"
#include "worker/loops/relocaliser.hpp"

namespace divemesh::loops {
namespace {

using synthetic::SeaFloor;

constexpr int kNumDisparities_px = 48;
constexpr std::uint64_t kSeed = 7;

types::RectifiedFrame frame_at(const Eigen::Isometry3d& T_world_cam,
                               int index = 0,
                               const SeaFloor& floor = SeaFloor()) {
    types::RectifiedFrame frame;
    frame.index = index;
    Eigen::Isometry3d T_world_right = T_world_cam;
    T_world_right.translate(Eigen::Vector3d(synthetic::small_rig().baseline_m, 0.0, 0.0));
    cv::extractChannel(floor.look(T_world_cam).left_color, frame.left, 0);
    cv::extractChannel(floor.look(T_world_right).left_color, frame.right, 0);
    return frame;
}

// Half of the image out of sight, and a turn in the image plane.
Eigen::Isometry3d wide_step() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << 1.1, 0.2, 0.15;
    T.rotate(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()));
    return T;
}

std::optional<Eigen::Isometry3d> registered(const Eigen::Isometry3d& T_world_to,
                                            const MotionPrior& prior = {},
                                            const SeaFloor& floor = SeaFloor()) {
    return register_wide_baseline(
        synthetic::small_rig(),
        sift_keypoints(frame_at(Eigen::Isometry3d::Identity(), 0, floor), kNumDisparities_px),
        sift_keypoints(frame_at(T_world_to, 1, floor), kNumDisparities_px),
        prior,
        kSeed);
}

TEST(WideBaselineTest, RegistersTurnedFramesThatShareHalfOfTheImage) {
    const auto T_b_a = registered(wide_step());
    ASSERT_TRUE(T_b_a);
    EXPECT_THAT(*T_b_a, synthetic::IsPoseWithin(wide_step().inverse(), 0.5, 0.02));
}

TEST(WideBaselineTest, AWrongRotationOfTheSensorsChangesNothing) {
    const types::KnownRotation wrong{
        Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX())), 1e-3};
    const auto T_b_a = registered(wide_step(), {std::nullopt, wrong});
    ASSERT_TRUE(T_b_a);
    EXPECT_THAT(*T_b_a, synthetic::IsPoseWithin(*registered(wide_step()), 1e-9, 1e-12));
}

TEST(WideBaselineTest, AnotherPlaceIsNotTaken) {
    Eigen::Isometry3d elsewhere = wide_step();
    elsewhere.translation().x() += 9.0;
    EXPECT_FALSE(registered(elsewhere));
}

TEST(WideBaselineTest, AFloorThatRepeatsIsNotTakenForAnotherOfItsPeriods) {
    const SeaFloor repeating(0.6);
    Eigen::Isometry3d beside = Eigen::Isometry3d::Identity();
    beside.translation() << 0.9, 0.0, 0.0;
    const auto T_b_a = registered(beside, {}, repeating);
    EXPECT_TRUE(!T_b_a || (*T_b_a * beside).translation().norm() < 0.02);
}

// Returns 200 features, spread over the image, at the depth of the floor.
types::Features grid_of_features(const types::RectifiedRig& rig) {
    types::Features features;
    for (int i = 0; i < 200; ++i) {
        types::Feature feature{100 + i, {15.0 + 15.0 * (i % 20), 15.0 + 22.0 * (i / 20)}, 0.0};
        feature.disparity_px = rig.disparity_px(SeaFloor::kDepth_m);
        features.push_back(feature);
    }
    return features;
}

TEST(RelocaliserTest, RecognisesAKeyframeAndItsFeatures) {
    const types::RectifiedRig rig = synthetic::small_rig();
    const Eigen::Isometry3d T_world_keyframe = Eigen::Isometry3d::Identity();
    const types::Features features = grid_of_features(rig);
    Relocaliser relocaliser(rig, false, kNumDisparities_px);
    const types::RectifiedFrame keyframe = frame_at(T_world_keyframe, 0);
    relocaliser.keep(keyframe, features, T_world_keyframe);
    relocaliser.pass(keyframe);
    Eigen::Isometry3d T_world_lost = T_world_keyframe;
    T_world_lost.translation().x() += 20.0;
    relocaliser.pass(frame_at(T_world_lost, 1));

    const auto recognised = relocaliser.recognise(frame_at(wide_step(), 2), T_world_lost, kSeed);

    ASSERT_TRUE(recognised);
    EXPECT_THAT(recognised->T_world_cam, synthetic::IsPoseWithin(wide_step(), 0.2, 0.01));
    ASSERT_EQ(recognised->features.size(), recognised->in_keyframe.size());
    EXPECT_GE(recognised->features.size(), 20U);
    for (std::size_t i = 0; i < recognised->features.size(); ++i) {
        const types::Feature& then = recognised->in_keyframe[i];
        EXPECT_EQ(recognised->features[i].id, then.id);
        const Eigen::Vector3d p_cam = wide_step().inverse() * types::point_cam(rig, then);
        EXPECT_LT((rig.pixel(p_cam) - recognised->features[i].pixel).norm(), 1.0);
    }
}

TEST(RelocaliserTest, FeaturesThatDidNotFollowTheSceneRecogniseNothing) {
    const types::RectifiedRig rig = synthetic::small_rig();
    const Eigen::Isometry3d T_world_keyframe = Eigen::Isometry3d::Identity();
    const types::Features features = grid_of_features(rig);
    Relocaliser relocaliser(rig, false, kNumDisparities_px);
    const types::RectifiedFrame keyframe = frame_at(T_world_keyframe, 0);
    relocaliser.keep(keyframe, features, T_world_keyframe);
    relocaliser.pass(keyframe);
    relocaliser.confirm({}, T_world_keyframe);  // all were in sight, none followed

    EXPECT_FALSE(relocaliser.recognise(frame_at(wide_step(), 2), wide_step(), kSeed));
}

}  // namespace
}  // namespace divemesh::loops
