#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "tests/synthetic/stereo_world.hpp"
#include "tests/synthetic/texture.hpp"
#include "worker/features/align_patch.hpp"
#include "worker/features/match_sparse_stereo.hpp"
#include "worker/features/track_features.hpp"

namespace divemesh::features {
namespace {

constexpr int kNumFeatures = 300;

types::RectifiedRig small_rig() { return synthetic::ideal_rig(320, 240, 500.0); }

TEST(PatchTest, FindsAShiftBelowThePixelUnderOtherLight) {
    const cv::Mat before = synthetic::textured_image(0.0, 0.0);
    const cv::Mat after = synthetic::textured_image(1.37, -0.82, 0.6, 90.0);
    const auto patch = Patch::read(before, {150.3, 100.6});
    ASSERT_TRUE(patch);

    const auto found = patch->align(after, {150.3, 100.6});

    ASSERT_TRUE(found);
    EXPECT_NEAR(found->pixel.x(), 151.67, 0.03);
    EXPECT_NEAR(found->pixel.y(), 99.78, 0.03);
    EXPECT_GT(found->correlation, 0.99);
}

TEST(PatchTest, RefusesWhatHasNoContrastOrLiesAtTheBorder) {
    const cv::Mat flat(240, 320, CV_8U, cv::Scalar(100));
    EXPECT_FALSE(Patch::read(flat, {100.0, 100.0}));
    EXPECT_FALSE(Patch::read(synthetic::textured_image(0.0, 0.0), {3.0, 100.0}));
}

TEST(MatchFeaturesTest, MeasuresDisparityBelowThePixelWithoutAPrior) {
    types::RectifiedFrame frame;
    frame.left = synthetic::textured_image(0.0, 0.0);
    frame.right = synthetic::textured_image(-23.4, 0.0, 0.8, 110.0);
    types::Features features;
    for (int i = 0; i < 40; ++i)
        features.push_back({i, {60.0 + 20.0 * (i % 8), 40.0 + 30.0 * (i / 8)}, 0.0});

    match_sparse_stereo(frame, {}, 64, features);

    int num_found = 0;
    for (const types::Feature& feature : features) {
        if (!types::has_depth(feature)) continue;
        ++num_found;
        EXPECT_NEAR(feature.disparity_px, 23.4, 0.1) << "feature " << feature.id;
    }
    EXPECT_GE(num_found, 30);
}

// A strip of a pair of large images, of a surface at 250.4 px.
types::RectifiedFrame near_surface() {
    types::RectifiedFrame frame;
    frame.left.create(40, 1280, CV_8U);
    frame.right.create(frame.left.size(), CV_8U);
    for (int v = 0; v < frame.left.rows; ++v)
        for (int u = 0; u < frame.left.cols; ++u) {
            frame.left.at<std::uint8_t>(v, u) =
                cv::saturate_cast<std::uint8_t>(128.0 + synthetic::texture(u, v));
            frame.right.at<std::uint8_t>(v, u) =
                cv::saturate_cast<std::uint8_t>(128.0 + synthetic::texture(u + 250.4, v));
        }
    return frame;
}

// Returns the number of features that are found on the near surface from a disparity known before.
int num_found_near(double known_px) {
    types::Features features;
    for (int i = 0; i < 40; ++i) features.push_back({i, {300.0 + 24.0 * i, 20.0}, known_px});
    match_sparse_stereo(near_surface(), {}, 128, features);
    return static_cast<int>(
        std::count_if(features.begin(), features.end(), [](const types::Feature& feature) {
            return std::abs(feature.disparity_px - 250.4) < 0.1;
        }));
}

TEST(MatchFeaturesTest, FindsAsNearASurfaceInLargeImagesAsInSmallOnes) {
    EXPECT_GE(num_found_near(0.0), 30);
    EXPECT_GE(num_found_near(230.0), 30);
}

TEST(MatchFeaturesTest, SearchesLargeImagesOnlySoFarWhereTheDepthIsKnown) {
    EXPECT_EQ(num_found_near(20.0), 0);
}

TEST(FeatureTrackerTest, FollowsFeaturesUnderChangingLight) {
    FeatureTracker tracker(small_rig(), kNumFeatures);
    tracker.track(synthetic::textured_image(0.0, 0.0), {}, Eigen::Isometry3d::Identity());
    const types::Features before = tracker.detect({});
    ASSERT_GE(before.size(), 100U);

    const types::Features after = tracker.track(
        synthetic::textured_image(3.2, -2.6, 0.8, 100.0), before, Eigen::Isometry3d::Identity());

    EXPECT_GE(after.size(), before.size() * 6 / 10);
    for (const types::Feature& feature : after) {
        const types::Feature& start = before[static_cast<std::size_t>(feature.id)];
        EXPECT_LT((feature.pixel - start.pixel - Eigen::Vector2d(3.2, -2.6)).norm(), 0.25);
    }
}

// Returns a mask of the left half of a small image.
cv::Mat left_half() {
    cv::Mat mask = cv::Mat::zeros(240, 320, CV_8U);
    mask.colRange(0, 160) = 255;
    return mask;
}

TEST(FeatureTrackerTest, AFixedPatternGivesNoNewFeatures) {
    FeatureTracker tracker(small_rig(), kNumFeatures);
    tracker.track(synthetic::textured_image(0.0, 0.0), {}, Eigen::Isometry3d::Identity());

    const types::Features features = tracker.detect({}, left_half());

    EXPECT_GE(features.size(), 40U);
    for (const types::Feature& feature : features) EXPECT_GE(feature.pixel.x(), 160.0);
}

TEST(MatchFeaturesTest, AFixedPatternHasNoDepth) {
    types::RectifiedFrame frame;
    frame.left = synthetic::textured_image(0.0, 0.0);
    frame.right = synthetic::textured_image(-23.4, 0.0);
    frame.fixed_pattern = left_half();
    types::Features features;
    for (int i = 0; i < 8; ++i) features.push_back({i, {60.0 + 30.0 * i, 120.0}, 0.0});

    match_sparse_stereo(frame, {}, 64, features);

    int num_found = 0;
    for (const types::Feature& feature : features) {
        if (!types::has_depth(feature)) continue;
        ++num_found;
        EXPECT_GE(feature.pixel.x(), 159.5);
    }
    EXPECT_GE(num_found, 2);
}

TEST(FeatureTrackerTest, ADarkImageGivesNoFeatures) {
    FeatureTracker tracker(small_rig(), kNumFeatures);
    const cv::Mat black(240, 320, CV_8U, cv::Scalar(0));
    tracker.track(black, {}, Eigen::Isometry3d::Identity());
    EXPECT_TRUE(tracker.detect({}).empty());
}

}  // namespace
}  // namespace divemesh::features
