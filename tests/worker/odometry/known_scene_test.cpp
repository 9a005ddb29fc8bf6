#include "worker/odometry/known_scene.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/odometry/register_with_rotation.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kInterval_ns = 100'000'000;
constexpr int kAppears = 10;  // frame before which a board is carried in front of the rig
constexpr double kNoise_px = 0.1;

// A rig on its path along a wall, and a board at half the distance with more features than the wall
// shows, which moves by itself.
struct Passer {
    types::Features see(int frame) {
        types::Features features = wall.see(synthetic::T_world_cam(frame), frame, kNoise_px);
        if (frame < kAppears) return features;
        for (int i = 0; i < num_on_board; ++i) {
            const Eigen::Vector3d p_cam(-0.4 + 0.05 * (i % 16) + 0.05 * (frame - kAppears),
                                        -0.3 + 0.03 * (i / 16) - 0.02 * (frame - kAppears),
                                        distance_m);
            const Eigen::Vector3d m = types::project_px(synthetic::rig(), p_cam);
            features.push_back({10'000 + i, m.head<2>(), m.z()});
        }
        return features;
    }

    synthetic::World wall{1.0, 0.0, 3};
    int num_on_board = 300;
    double distance_m = 1.0;
};

// Follows the rig up to a frame by all features; the scene is known afterwards.
KnownScene scene_before(int end, Passer& passer) {
    KnownScene scene(synthetic::rig());
    types::Features before = passer.see(0);
    for (int frame = 1; frame < end; ++frame) {
        const types::Features now = passer.see(frame);
        const PointPairs pairs = with_depth_at_both_times(synthetic::rig(), before, now);
        const Registration motion = register_with_rotation(
            synthetic::rig(), pairs, std::nullopt, Eigen::Isometry3d::Identity(), 2.0, 1);
        scene.update(pairs,
                     motion,
                     synthetic::T_world_cam(frame - 1),
                     (frame - 1) * kInterval_ns,
                     frame * kInterval_ns);
        before = now;
    }
    return scene;
}

Eigen::Isometry3d true_motion(int frame) {
    return synthetic::T_world_cam(frame).inverse() * synthetic::T_world_cam(frame - 1);
}

struct Step {
    types::Features before;
    PointPairs pairs;
    Registration by_majority;
};

Step step_to(int frame, Passer& passer) {
    Step step;
    step.before = passer.see(frame - 1);
    step.pairs = with_depth_at_both_times(synthetic::rig(), step.before, passer.see(frame));
    step.by_majority = register_with_rotation(
        synthetic::rig(), step.pairs, std::nullopt, Eigen::Isometry3d::Identity(), 2.0, 1);
    return step;
}

TEST(KnownSceneTest, ABoardThatFillsTheImageDoesNotOutvoteTheSceneBehindIt) {
    Passer passer;
    const KnownScene scene = scene_before(kAppears, passer);
    const Step step = step_to(kAppears + 1, passer);

    ASSERT_GT((step.by_majority.T_current_previous * true_motion(kAppears + 1).inverse())
                  .translation()
                  .norm(),
              0.02);
    EXPECT_TRUE(scene.contradicts(step.before, step.pairs, step.by_majority));
    const Registration by_known = register_with_rotation(synthetic::rig(),
                                                         scene.known(step.pairs),
                                                         std::nullopt,
                                                         Eigen::Isometry3d::Identity(),
                                                         2.0,
                                                         1);
    EXPECT_THAT(by_known.T_current_previous,
                synthetic::IsPoseWithin(true_motion(kAppears + 1), 0.2, 0.005));
    EXPECT_FALSE(scene.contradicts(step.before, step.pairs, by_known));
    EXPECT_TRUE(scene.confirms(by_known, true_motion(kAppears + 1)));
    EXPECT_FALSE(scene.confirms(by_known, std::nullopt));
}

TEST(KnownSceneTest, ABoardThatHidesTheSceneIsNoNewScene) {
    Passer passer;
    const KnownScene scene = scene_before(kAppears, passer);
    Step step = step_to(kAppears + 1, passer);
    std::erase_if(step.by_majority.inliers, [](const PointPair& pair) { return pair.id < 10'000; });

    EXPECT_TRUE(scene.is_hidden_behind(step.by_majority, synthetic::T_world_cam(kAppears)));
}

TEST(KnownSceneTest, NewFeaturesOnTheKnownSurfaceAreTaken) {
    Passer passer;
    const KnownScene scene = scene_before(kAppears, passer);
    passer.distance_m = 2.0;  // as far as the wall
    Step step = step_to(kAppears + 1, passer);
    std::erase_if(step.by_majority.inliers, [](const PointPair& pair) { return pair.id < 10'000; });

    EXPECT_FALSE(scene.is_hidden_behind(step.by_majority, synthetic::T_world_cam(kAppears)));
}

TEST(KnownSceneTest, AnHonestMotionIsNotContradicted) {
    Passer passer;
    passer.num_on_board = 0;
    const KnownScene scene = scene_before(kAppears, passer);
    const Step step = step_to(kAppears, passer);
    EXPECT_FALSE(scene.contradicts(step.before, step.pairs, step.by_majority));
    EXPECT_FALSE(scene.is_hidden_behind(step.by_majority, synthetic::T_world_cam(kAppears - 1)));
}

TEST(KnownSceneTest, FeaturesThatSlideOffTheirFirstPositionStayUnknown) {
    Passer passer;
    passer.num_on_board = 0;
    KnownScene scene(synthetic::rig());
    for (int frame = 1; frame < 12; ++frame) {  // a pixel a frame, within the outlier tolerance
        Registration motion;
        motion.found = true;
        PointPair pair;
        pair.id = 1;
        pair.p_previous = {0.004 * (frame - 1), 0.0, 2.0};
        pair.p_current = {0.004 * frame, 0.0, 2.0};
        pair.previous_px = types::project_px(synthetic::rig(), pair.p_previous);
        pair.current_px = types::project_px(synthetic::rig(), pair.p_current);
        motion.inliers = {pair};
        scene.update({pair},
                     motion,
                     Eigen::Isometry3d::Identity(),
                     (frame - 1) * kInterval_ns,
                     frame * kInterval_ns);
        EXPECT_TRUE(scene.known({pair}).empty()) << frame;
        EXPECT_TRUE(scene.has_followed(1));
    }
}

}  // namespace
}  // namespace divemesh::odometry
