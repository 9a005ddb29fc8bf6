#include "worker/odometry/rest_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "tests/synthetic/stereo_world.hpp"

namespace divemesh::odometry {
namespace {

constexpr double kNoise_px = 0.1;

// A rig that sees a wall at 10 Hz while it moves.
struct Watched {
    int num_rests = 0;
    double worst_m = 0.0;  // distance of a rest from the true position
};

template <typename Motion>
Watched watch(int num_frames, const Motion& T_world_cam) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    Watched result;
    for (int k = 0; k < num_frames; ++k) {
        const Eigen::Isometry3d pose = T_world_cam(0.1 * k);
        const auto rest =
            detector.watch(std::int64_t{100'000'000} * k, world.see(pose, k, kNoise_px), pose);
        if (!rest) continue;
        ++result.num_rests;
        result.worst_m =
            std::max(result.worst_m, (rest->translation() - pose.translation()).norm());
    }
    return result;
}

Eigen::Isometry3d at(const Eigen::Vector3d& position) {
    return Eigen::Isometry3d(Eigen::Translation3d(position));
}

TEST(RestDetectorTest, ARigThatStandsStillRestsAfterASecond) {
    const Watched watched = watch(100, [](double) { return at({1.0, 0.0, 0.0}); });
    EXPECT_GE(watched.num_rests, 75);
    EXPECT_LT(watched.worst_m, 1e-3);  // one frame in a hundred exceeds the test's limit
}

TEST(RestDetectorTest, ARigThatSinksSlowlyDoesNotRest) {
    const Watched watched = watch(100, [](double t_s) {
        return at({1.0, 0.005 * t_s, 0.0});
    });  // 5 mm/s
    EXPECT_EQ(watched.num_rests, 0);
}

TEST(RestDetectorTest, ARigThatTurnsOnTheSpotDoesNotRest) {
    const Watched watched = watch(60, [](double t_s) {
        Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
        pose.linear() = base::rotation_from_vector({0.0, 0.0, 0.01 * t_s}).toRotationMatrix();
        return pose;
    });
    EXPECT_EQ(watched.num_rests, 0);
}

TEST(RestDetectorTest, ARestNeverHidesMoreThanTheNoiseOfOnePose) {
    // A quarter of a millimetre a second: seen as rest for some time, then anew from where it is.
    const Watched watched = watch(300, [](double t_s) { return at({1.0, 0.00025 * t_s, 0.0}); });
    EXPECT_LT(watched.worst_m, 1.5e-3);
}

TEST(RestDetectorTest, FeaturesThatFishDragAlongAreNoMotion) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    int num_moved = 0;
    for (int k = 0; k < 100; ++k) {
        types::Features seen = world.see(pose, k, 0.03);
        for (types::Feature& feature : seen)
            if (k >= 20 && feature.id % 9 < 4) feature.pixel.x() += 0.8;
        const auto rest = detector.watch(std::int64_t{100'000'000} * k, seen, pose);
        if (k < 15) continue;
        ASSERT_TRUE(rest) << k;
        if (!rest->isApprox(pose)) ++num_moved;
    }
    EXPECT_LE(num_moved, 8);
}

TEST(RestDetectorTest, LightThatShiftsAllFeaturesALittleIsNoMotion) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    int num_moved = 0;
    for (int k = 0; k < 100; ++k) {
        types::Features seen = world.see(pose, k, 0.02);
        const double shift_px = 0.05 * world.normal();
        for (types::Feature& feature : seen) feature.pixel.x() += shift_px;
        const auto rest = detector.watch(std::int64_t{100'000'000} * k, seen, pose);
        if (k < 20) continue;
        ASSERT_TRUE(rest) << k;
        if (!rest->isApprox(pose)) ++num_moved;
    }
    EXPECT_LE(num_moved, 8);
}

TEST(RestDetectorTest, ARestGoesOnWhereTheMapIsCorrected) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    const Eigen::Isometry3d corrected = at({1.1, 0.02, -0.03});
    for (int k = 0; k < 60; ++k) {
        const auto rest = detector.watch(std::int64_t{100'000'000} * k,
                                         world.see(pose, k, kNoise_px),
                                         k <= 30 ? pose : corrected);
        if (k == 30) detector.correct(corrected);
        if (k <= 30) continue;
        ASSERT_TRUE(rest) << k;
        EXPECT_LT((rest->translation() - corrected.translation()).norm(), 1e-3) << k;
        EXPECT_LT(detector.began_ns(), 1'000'000'000) << k;
    }
}

// Returns features in which two thirds swim to the right by a third of a pixel per frame.
types::Features with_fish(types::Features seen, int frame) {
    for (std::size_t i = 0; i < seen.size(); ++i)
        if (i % 3 != 0) seen[i].pixel.x() += 0.3 * frame;
    return seen;
}

TEST(RestDetectorTest, FishHideNoRestThatTheImuKnows) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector by_images(synthetic::rig());
    RestDetector with_imu(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    int num_by_images = 0;
    for (int k = 0; k < 60; ++k) {
        const types::Features seen = with_fish(world.see(pose, k, kNoise_px), k);
        const std::int64_t now_ns = std::int64_t{100'000'000} * k;
        if (by_images.watch(now_ns, seen, pose)) ++num_by_images;
        const auto rest = with_imu.watch(now_ns, seen, pose, RestDetector::Seen::AllFeaturesAtRest);
        if (k < 15) continue;
        ASSERT_TRUE(rest) << k;
        EXPECT_LT((rest->translation() - pose.translation()).norm(), 5e-3) << k;
    }
    EXPECT_EQ(num_by_images, 0);
}

// An even glide shakes no IMU.
TEST(RestDetectorTest, AGlideIsNoRestThoughTheImuSaysSo) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    for (int k = 0; k < 60; ++k) {
        const Eigen::Isometry3d pose = at({1.0, 0.005 * k, 0.0});  // 5 cm/s
        EXPECT_FALSE(detector.watch(std::int64_t{100'000'000} * k,
                                    world.see(pose, k, kNoise_px),
                                    pose,
                                    RestDetector::Seen::AllFeaturesAtRest))
            << k;
    }
}

TEST(RestDetectorTest, ARestOutlastsWhatHidesMostOfTheScene) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    for (int k = 0; k < 60; ++k) {
        types::Features seen = world.see(pose, k, kNoise_px);
        if (k >= 30 && k < 40) seen.resize(8);
        const auto rest = detector.watch(std::int64_t{100'000'000} * k, seen, pose);
        if (k < 20) continue;
        ASSERT_TRUE(rest) << k;
        EXPECT_LT((rest->translation() - pose.translation()).norm(), 5e-3) << k;
    }
}

TEST(RestDetectorTest, FeaturesThatAppearDuringARestJoinIt) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    for (int k = 0; k < 60; ++k) {
        const types::Features all = world.see(pose, k, kNoise_px);
        const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
        const types::Features seen = k < 30   ? types::Features(all.begin(), middle)
                                     : k < 40 ? all
                                              : types::Features(middle, all.end());
        const auto rest = detector.watch(std::int64_t{100'000'000} * k, seen, pose);
        if (k < 20) continue;
        ASSERT_TRUE(rest) << k;
    }
}

// Returns the features of even ids, or the others.
types::Features half(const types::Features& all, bool even) {
    types::Features seen;
    std::ranges::copy_if(all, std::back_inserter(seen), [&](const types::Feature& feature) {
        return (feature.id % 2 == 0) == even;
    });
    return seen;
}

// One half of the features is hidden within a frame, and the other one was new in the frame before.
TEST(RestDetectorTest, ARestOutlastsWhatHidesAllOfItsFeaturesWithinAFrame) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    constexpr int kHidden = 20;
    types::Features last;
    for (int k = 0; k < 40; ++k) {
        const types::Features all = world.see(pose, k, kNoise_px);
        detector.join(half(last, k < kHidden));
        const auto rest =
            detector.watch(std::int64_t{100'000'000} * k, half(all, k < kHidden), pose);
        last = all;
        if (k < kHidden - 2) continue;
        ASSERT_TRUE(rest) << k;
        EXPECT_LT((rest->translation() - pose.translation()).norm(), 5e-3) << k;
    }
}

// As a scene that a person walks past: keyframes are added before a rest is known to be one.
TEST(RestDetectorTest, AMapThatIsCorrectedInTheFirstSecondDelaysNoRest) {
    synthetic::World world(2.0, 0.0, 7);
    RestDetector detector(synthetic::rig());
    const Eigen::Isometry3d pose = at({1.0, 0.0, 0.0});
    const Eigen::Isometry3d corrected = at({1.1, 0.02, -0.03});
    for (int k = 0; k < 20; ++k) {
        const auto rest = detector.watch(std::int64_t{100'000'000} * k,
                                         world.see(pose, k, kNoise_px),
                                         k <= 6 ? pose : corrected);
        if (k == 6) detector.correct(corrected);
        if (k <= 11) continue;
        ASSERT_TRUE(rest) << k;
        EXPECT_LT((rest->translation() - corrected.translation()).norm(), 2e-3) << k;
    }
}

}  // namespace
}  // namespace divemesh::odometry
