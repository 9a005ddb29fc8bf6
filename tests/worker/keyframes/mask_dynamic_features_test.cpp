#include "worker/keyframes/mask_dynamic_features.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace divemesh::keyframes {
namespace {

// Returns the depth of a wall at a disparity of 20 px, with a fish of 60 x 30 px at 40 px in front
// of it.
types::DepthMap wall_and_fish() {
    types::DepthMap depth;
    depth.disparity_px = cv::Mat(240, 320, CV_32F, cv::Scalar(20.0));
    depth.disparity_px(cv::Rect(100, 80, 60, 30)).setTo(40.0F);
    depth.sigma_disparity_px = cv::Mat(240, 320, CV_32F, cv::Scalar(0.2));
    return depth;
}

TEST(MaskDynamicFeaturesTest, TakesOutTheFishAndLeavesTheWall) {
    types::DepthMap depth = wall_and_fish();
    mask_dynamic_features({{7, {120.0, 90.0}, 40.3}}, {{3, {50.0, 90.0}, 20.0}}, depth);
    EXPECT_EQ(depth.disparity_px.at<float>(95, 130), 0.0F);
    EXPECT_EQ(depth.disparity_px.at<float>(78, 130), 0.0F);  // its border
    EXPECT_EQ(depth.disparity_px.at<float>(60, 130), 20.0F);
    EXPECT_EQ(depth.disparity_px.at<float>(200, 30), 20.0F);
}

TEST(MaskDynamicFeaturesTest, ATrackThatSlippedTakesNothingOfTheScene) {
    types::DepthMap depth = wall_and_fish();
    mask_dynamic_features({{7, {250.0, 90.0}, 20.2}, {8, {120.0, 90.0}, 33.0}}, {}, depth);
    EXPECT_EQ(cv::norm(depth.disparity_px, wall_and_fish().disparity_px, cv::NORM_INF), 0.0);
    mask_dynamic_features({{7, {120.0, 90.0}, 40.0}}, {{3, {150.0, 100.0}, 40.0}}, depth);
    EXPECT_EQ(cv::norm(depth.disparity_px, wall_and_fish().disparity_px, cv::NORM_INF), 0.0);
}

TEST(MaskDynamicFeaturesTest, EachOfTwoFishGoesHoweverManyTracksAreOnThemAndOnTheWall) {
    types::DepthMap depth = wall_and_fish();
    depth.disparity_px(cv::Rect(200, 150, 40, 40)).setTo(30.0F);
    mask_dynamic_features({{1, {250.0, 90.0}, 20.2},
                           {2, {120.0, 90.0}, 40.3},
                           {3, {150.0, 100.0}, 39.8},
                           {4, {20.0, 20.0}, 19.9},
                           {5, {220.0, 170.0}, 30.1}},
                          {},
                          depth);
    const int num_out = 240 * 320 - cv::countNonZero(depth.disparity_px);
    EXPECT_GT(num_out, 60 * 30 + 40 * 40);
    EXPECT_LE(num_out, 66 * 36 + 46 * 46);  // with their borders
    EXPECT_EQ(depth.disparity_px.at<float>(95, 155), 0.0F);
    EXPECT_EQ(depth.disparity_px.at<float>(170, 220), 0.0F);
}

}  // namespace
}  // namespace divemesh::keyframes
