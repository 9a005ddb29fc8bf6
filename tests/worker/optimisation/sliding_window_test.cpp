#include "worker/optimisation/sliding_window.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/optimisation/follow_keyframes.hpp"

namespace divemesh::optimisation {
namespace {

using synthetic::IsPoseWithin;

constexpr int kStep = 6;  // frames between keyframes
constexpr int kNumKeyframes = 20;

imu::SensorReadings perfect_rotation(int from, int to) {
    const auto R_world_imu = [](int frame) {
        return Eigen::Quaterniond(synthetic::T_world_cam(frame).linear() *
                                  synthetic::rig().T_imu_cam.linear().transpose());
    };
    imu::GyroscopeIntegral rotation;
    rotation.duration_s = 0.1 * (to - from);
    rotation.q_from_to = R_world_imu(from).conjugate() * R_world_imu(to);
    rotation.d_rotation_d_bias = -rotation.duration_s * Eigen::Matrix3d::Identity();
    rotation.sigma_rad = 2e-4;
    imu::SensorReadings readings;
    readings.interval_s = rotation.duration_s;
    readings.rotation = rotation;
    return readings;
}

// Swims along the wall: RANSAC against the last keyframe, with landmarks once they are known; a
// keyframe every kStep frames.
SlidingWindow swim(double noise_px, double fish_share, bool gyroscope) {
    const types::RectifiedRig rig = synthetic::rig();
    synthetic::World world(0.03 * kStep * kNumKeyframes, fish_share, 11);
    SlidingWindow window(rig, types::ImuNoise{2e-4, 1e-5});
    types::Features before = world.see(synthetic::T_world_cam(0), 0, noise_px);
    window.add_keyframe({0, 0, synthetic::T_world_cam(0)}, before, {});
    for (int k = 1; k <= kNumKeyframes; ++k) {
        const int frame = kStep * k;
        const types::Features now = world.see(synthetic::T_world_cam(frame), frame, noise_px);
        odometry::PointPairs pairs = odometry::with_depth_at_both_times(rig, before, now);
        window.use_landmarks(window.T_world_cam(), pairs);
        const odometry::Registration motion = odometry::register_points(rig, pairs, 3.0, 1);
        const Eigen::Isometry3d T_now_before =
            odometry::refine_pose(
                rig, motion.inliers, odometry::predict_orientation(std::nullopt, motion))
                .T_current_previous;
        const types::Keyframe keyframe{
            frame, frame * 100'000'000LL, window.T_world_cam() * T_now_before.inverse()};
        types::Features kept;
        for (const types::Feature& feature : now) {
            const auto is = [&](const odometry::PointPair& pair) { return pair.id == feature.id; };
            const bool paired = std::any_of(pairs.begin(), pairs.end(), is);
            if (!paired || std::any_of(motion.inliers.begin(), motion.inliers.end(), is))
                kept.push_back(feature);
        }
        window.add_keyframe(
            keyframe,
            kept,
            gyroscope ? perfect_rotation(frame - kStep, frame) : imu::SensorReadings{});
        window.adjust();
        before = now;
    }
    return window;
}

TEST(SlidingWindowTest, FollowsThreeAndAHalfMetresExactlyWithoutNoise) {
    const SlidingWindow window = swim(0.0, 0.0, false);
    EXPECT_THAT(window.T_world_cam(),
                IsPoseWithin(synthetic::T_world_cam(kStep * kNumKeyframes), 1e-3, 1e-4));
}

TEST(SlidingWindowTest, DriftsLessThanHalfAPercentOnNoisyFeatures) {
    const SlidingWindow window = swim(0.3, 0.0, false);
    EXPECT_THAT(window.T_world_cam(),
                IsPoseWithin(synthetic::T_world_cam(kStep * kNumKeyframes), 0.4, 0.018));
}

TEST(SlidingWindowTest, IsNotCarriedAwayByThirtyPercentFish) {
    const SlidingWindow window = swim(0.3, 0.3, true);
    EXPECT_THAT(window.T_world_cam(),
                IsPoseWithin(synthetic::T_world_cam(kStep * kNumKeyframes), 0.2, 0.018));
}

TEST(SlidingWindowTest, LandmarksSeenOnceFollowTheCorrectionOfTheirKeyframe) {
    synthetic::World world(1.0, 0.0, 11);
    SlidingWindow window(synthetic::rig(), types::ImuNoise{2e-4, 1e-5});
    const auto is_old = [](const types::Feature& feature) { return feature.id % 2 == 0; };
    const auto see = [&](int frame) {
        return world.see(synthetic::T_world_cam(frame), frame, 0.0);
    };
    types::Features first = see(0);
    std::erase_if(first, [&](const types::Feature& feature) { return !is_old(feature); });
    window.add_keyframe({0, 0, synthetic::T_world_cam(0)}, first, {});
    Eigen::Isometry3d wrong = synthetic::T_world_cam(kStep);
    wrong.translation().x() += 0.05;
    window.add_keyframe({1, 1'000'000'000, wrong}, see(kStep), {});
    window.adjust();
    ASSERT_THAT(window.T_world_cam(), IsPoseWithin(synthetic::T_world_cam(kStep), 0.01, 1e-3));

    types::Features last = see(2 * kStep);
    std::erase_if(last, is_old);
    window.add_keyframe({2, 2'000'000'000, synthetic::T_world_cam(2 * kStep)}, last, {});
    window.adjust();

    std::size_t num_links = 0;
    for (const types::Landmark& landmark : window.landmarks())
        if (landmark.observations.back().keyframe == 2) ++num_links;
    EXPECT_GT(num_links, 50U);
}

TEST(SlidingWindowTest, GivesTheSameBitsAgain) {
    const SlidingWindow once = swim(0.3, 0.3, true);
    const SlidingWindow again = swim(0.3, 0.3, true);
    EXPECT_EQ(once.T_world_cam().matrix(), again.T_world_cam().matrix());
}

TEST(FollowKeyframesTest, FramesGoWithTheKeyframesAroundThem) {
    types::Trajectory odometry;
    for (int i = 0; i <= 10; ++i) {
        types::StampedPose pose;
        pose.timestamp_ns = 100 * i;
        pose.T_world_imu.translation().x() = i;
        odometry.push_back(pose);
    }
    std::vector<types::Keyframe> keyframes = {{0, 0}, {5, 500}, {10, 1000}};
    keyframes[0].T_world_cam.translation() << 0.0, 0.0, 0.0;
    keyframes[1].T_world_cam.translation() << 5.0, 1.0, 0.0;
    keyframes[2].T_world_cam.translation() << 10.0, 1.0, 0.0;

    const types::Trajectory frames =
        follow_keyframes(odometry,
                         std::vector<types::MotionSigma>(odometry.size(), {0.01, 0.001}),
                         keyframes,
                         Eigen::Isometry3d::Identity());

    ASSERT_EQ(frames.size(), odometry.size());
    EXPECT_NEAR(frames[2].T_world_imu.translation().y(), 0.4, 1e-9);
    EXPECT_NEAR(frames[5].T_world_imu.translation().y(), 1.0, 1e-9);
    EXPECT_NEAR(frames[7].T_world_imu.translation().y(), 1.0, 1e-9);
    EXPECT_NEAR(frames[7].T_world_imu.translation().x(), 7.0, 1e-9);
}

}  // namespace
}  // namespace divemesh::optimisation
