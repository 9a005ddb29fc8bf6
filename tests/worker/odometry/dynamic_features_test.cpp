#include "worker/odometry/dynamic_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/odometry/register_with_rotation.hpp"

namespace divemesh::odometry {
namespace {

TEST(DynamicFeaturesTest, FishAreFollowedOnAndTakenOutOfTheTracks) {
    synthetic::World world(1.0, 0.2, 3);
    const types::RectifiedRig rig = synthetic::rig();
    DynamicFeatures dynamic(rig);
    types::Features scene = world.see(synthetic::T_world_cam(10), 10, 0.1);
    for (int frame = 11; frame < 14; ++frame) {
        const types::Features before = dynamic.with_dynamic(scene);
        const types::Features all = world.see(synthetic::T_world_cam(frame), frame, 0.1);
        types::Features tracks;
        std::copy_if(
            all.begin(), all.end(), std::back_inserter(tracks), [&](const types::Feature& f) {
                return std::any_of(before.begin(), before.end(), [&](const types::Feature& b) {
                    return b.id == f.id;
                });
            });
        dynamic.take_dynamic(tracks);
        const PointPairs pairs = with_depth_at_both_times(rig, scene, tracks);
        const Registration motion =
            register_with_rotation(rig, pairs, std::nullopt, Eigen::Isometry3d::Identity(), 2.0, 1);
        dynamic.classify(pairs, motion);
        scene.clear();
        for (const PointPair& pair : motion.inliers)
            scene.push_back(
                *std::find_if(all.begin(), all.end(), [&](auto& f) { return f.id == pair.id; }));
    }
    ASSERT_GE(dynamic.now().size(), 15U);
    for (const types::Feature& feature : dynamic.now()) EXPECT_TRUE(world.is_fish(feature.id));
}

}  // namespace
}  // namespace divemesh::odometry
