#include "worker/stereo/combine_scales.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

types::DepthMap plane(int width, int height, float disparity_px, float slope, float sigma_px) {
    types::DepthMap depth;
    depth.disparity_px.create(height, width, CV_32F);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            depth.disparity_px.at<float>(y, x) = disparity_px + slope * static_cast<float>(x);
    depth.sigma_disparity_px = cv::Mat(height, width, CV_32F, cv::Scalar(sigma_px));
    return depth;
}

types::DepthMap full(float sigma_px) { return plane(kWidth, kHeight, 20.0F, 0.1F, sigma_px); }

// The same plane at half the size: d' = d / 2 at x = 2 x' + 1 / 2.
types::DepthMap half(float error_px, float sigma_px) {
    return plane(kWidth / 2, kHeight / 2, 0.5F * (20.05F + error_px), 0.1F, 0.5F * sigma_px);
}

void forget(types::DepthMap& depth, const cv::Rect& where) {
    depth.disparity_px(where).setTo(0.0F);
    depth.sigma_disparity_px(where).setTo(0.0F);
}

const cv::Rect kHole(60, 50, 12, 10);
const cv::Point kInHole(66, 55);
const cv::Point kBesideHole(30, 55);

float truth_px(const cv::Point& at) { return 20.0F + 0.1F * static_cast<float>(at.x); }

TEST(CombineScales, FillsAHoleWithALargeSigma) {
    types::DepthMap depth = full(0.2F);
    forget(depth, kHole);
    combine_scales(half(0.0F, 0.4F), depth);
    for (int y = kHole.y; y < kHole.y + kHole.height; ++y)
        for (int x = kHole.x; x < kHole.x + kHole.width; ++x) {
            EXPECT_NEAR(depth.disparity_px.at<float>(y, x), truth_px({x, y}), 1e-3);
            EXPECT_GE(depth.sigma_disparity_px.at<float>(y, x), 1.0F);
        }
}

TEST(CombineScales, LeavesWhatTheFullSizeKnowsWell) {
    types::DepthMap depth = full(0.2F);
    combine_scales(half(0.6F, 0.4F), depth);
    EXPECT_EQ(cv::norm(depth.disparity_px, full(0.2F).disparity_px, cv::NORM_INF), 0.0);
    EXPECT_EQ(depth.sigma_disparity_px.at<float>(kBesideHole), 0.2F);
}

TEST(CombineScales, TrustsNothingThatTheHalfSizeContradicts) {
    types::DepthMap depth = full(0.2F);
    combine_scales(half(3.0F, 0.4F), depth);
    EXPECT_FLOAT_EQ(depth.disparity_px.at<float>(kBesideHole), truth_px(kBesideHole));
    EXPECT_GT(depth.sigma_disparity_px.at<float>(kBesideHole), 1.4F);
}

// Two measurements of the same number, by their variances.
TEST(CombineScales, AveragesWhatTheFullSizeKnowsVaguely) {
    types::DepthMap depth = full(1.0F);
    combine_scales(half(0.5F, 0.5F), depth);
    EXPECT_NEAR(depth.disparity_px.at<float>(kBesideHole), truth_px(kBesideHole) + 0.4, 1e-3);
    EXPECT_NEAR(
        depth.sigma_disparity_px.at<float>(kBesideHole), std::hypot(std::sqrt(0.2), 0.25), 1e-3);
}

TEST(CombineScales, AddsNothingInFrontOfFartherSurface) {
    types::DepthMap wide = half(0.0F, 0.4F);
    wide.disparity_px.colRange(kWidth / 4, kWidth / 2) -= 6.0F;  // farther on the right
    types::DepthMap depth = full(0.2F);
    const cv::Rect around_edge(kWidth / 2 - 20, 20, 40, 60);
    forget(depth, around_edge);
    combine_scales(wide, depth);
    const int y = 50;
    EXPECT_EQ(depth.disparity_px.at<float>(y, kWidth / 2 - 4), 0.0F);
    EXPECT_GT(depth.disparity_px.at<float>(y, kWidth / 2 - 18), 0.0F);
    EXPECT_NEAR(depth.disparity_px.at<float>(y, kWidth / 2 + 4),
                truth_px({kWidth / 2 + 4, y}) - 12.0F,
                1e-3);
}

TEST(CombineScales, AddsNothingWhereTheHalfSizeKnowsNothing) {
    types::DepthMap nothing = half(0.0F, 0.4F);
    forget(nothing, {0, 0, kWidth / 2, kHeight / 2});
    types::DepthMap depth = full(1.0F);
    forget(depth, kHole);
    combine_scales(nothing, depth);
    EXPECT_EQ(depth.disparity_px.at<float>(kInHole), 0.0F);
    EXPECT_EQ(depth.sigma_disparity_px.at<float>(kBesideHole), 1.0F);
}

// As in haze: the contrast of the surface is no larger than the noise.
TEST(StereoMatcher, SeesMoreInNoiseWithTwoScales) {
    WarpedPairOptions options;
    options.contrast = 0.07;
    options.noise = 3.0;
    const auto pair =
        make_warped_pair([](double x, double y) { return 14.0 + 0.05 * x + 0.03 * y; }, options);
    types::RectifiedFrame frame;
    frame.left = pair.left;
    frame.right = pair.right;
    const auto error = [&](int num_scales) {
        const types::DepthMap depth = StereoMatcher("sgm", 64, num_scales).match(frame);
        return compare_disparity(depth.disparity_px, pair.disparity_px, 63.0);
    };
    const DisparityError one = error(1), two = error(2);
    EXPECT_GT(two.density, one.density + 0.05);
    EXPECT_LT(two.median_px, one.median_px);
    EXPECT_LT(two.bad1, one.bad1);
}

}  // namespace
}  // namespace divemesh::stereo
