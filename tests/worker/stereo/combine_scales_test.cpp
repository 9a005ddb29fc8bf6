#include "worker/stereo/combine_scales.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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

struct Estimate {
    float disparity_px = 0.0F;
    float sigma_px = 0.0F;
};

// The definition, pixel by pixel. `half` is as matched; returns 0 where it tells nothing.
Estimate half_at(const types::DepthMap& half, int x, int y) {
    const cv::Mat& disparity = half.disparity_px;
    const auto trusted = [&](int u, int v) {
        const float d = disparity.at<float>(v, u);
        for (int j = std::max(0, v - 5); j <= std::min(disparity.rows - 1, v + 5); ++j)
            for (int i = std::max(0, u - 5); i <= std::min(disparity.cols - 1, u + 5); ++i)
                if (const float farther = disparity.at<float>(j, i);
                    farther > 0.0F && d - farther > 2.0F)
                    return 0.0F;
        return d;
    };
    const auto at = [](int i, int num) {
        return std::clamp(0.5F * (static_cast<float>(i) - 0.5F), 0.0F, static_cast<float>(num - 1));
    };
    const float u = at(x, disparity.cols);
    const float v = at(y, disparity.rows);
    const int left = std::min(static_cast<int>(u), disparity.cols - 2);
    const int top = std::min(static_cast<int>(v), disparity.rows - 2);
    const float right_part = u - static_cast<float>(left);
    const float lower_part = v - static_cast<float>(top);
    const float nearest =
        trusted(left + (right_part < 0.5F ? 0 : 1), top + (lower_part < 0.5F ? 0 : 1));
    if (nearest <= 0.0F) return {};
    float weights = 0.0F;
    float sum = 0.0F;
    float sum_sigma = 0.0F;
    for (const int j : {0, 1})
        for (const int i : {0, 1}) {
            const float d = trusted(left + i, top + j);
            if (d <= 0.0F || std::abs(d - nearest) > 1.0F) continue;
            const float weight = (i == 0 ? 1.0F - right_part : right_part) *
                                 (j == 0 ? 1.0F - lower_part : lower_part);
            weights += weight;
            sum += weight * d;
            sum_sigma += weight * half.sigma_disparity_px.at<float>(top + j, left + i);
        }
    return {2.0F * sum / weights, std::max(2.0F * sum_sigma / weights, 0.15F)};
}

Estimate expected(const Estimate& full, const Estimate& half) {
    if (half.disparity_px <= 0.0F) return full;
    if (full.disparity_px <= 0.0F) {
        const float sigma = std::sqrt(half.sigma_px * half.sigma_px + 1.0F);
        return sigma > 3.0F ? Estimate{} : Estimate{half.disparity_px, sigma};
    }
    const float difference = half.disparity_px - full.disparity_px;
    const auto raised = [&](float sigma) {
        const float disagreement = 0.5F * difference;
        return std::min(3.0F, std::sqrt(sigma * sigma + disagreement * disagreement));
    };
    const bool is_certain = full.sigma_px <= 0.75F;
    if (is_certain && std::abs(difference) <= 1.0F) return full;
    const float of_full = full.sigma_px * full.sigma_px;
    const float of_half = half.sigma_px * half.sigma_px;
    const float of_both = of_full + of_half;
    if (is_certain || difference * difference >= 6.25F * of_both)
        return {full.disparity_px, raised(full.sigma_px)};
    return {full.disparity_px + difference * of_full / of_both,
            std::max(0.15F, raised(std::sqrt(of_full * of_half / of_both)))};
}

// Surfaces at several depths with holes; disparities and sigmas at random around every threshold.
types::DepthMap rough(cv::Size size, float scale, std::uint64_t seed) {
    cv::RNG random(seed);
    types::DepthMap depth{cv::Mat(size, CV_32F), cv::Mat(size, CV_32F)};
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const int patch = static_cast<int>(scale) * (x / 23 + 5 * (y / 19));
            const float base_px =
                30.0F + static_cast<float>(patch % 4) * random.uniform(0.0F, 1.3F);
            const bool known = random.uniform(0.0F, 1.0F) < 0.8F;
            depth.disparity_px.at<float>(y, x) =
                known ? (base_px + random.uniform(-1.0F, 1.0F)) / scale : 0.0F;
            depth.sigma_disparity_px.at<float>(y, x) =
                known ? random.uniform(0.05F, 2.0F) / scale : 0.0F;
        }
    return depth;
}

TEST(CombineScales, GivesTheBytesOfItsDefinitionOnEveryInstructionSet) {
    for (const cv::Size size : {cv::Size(160, 96), cv::Size(163, 97), cv::Size(86, 81)}) {
        const types::DepthMap half = rough({size.width / 2, size.height / 2}, 2.0F, 4);
        const types::DepthMap before = rough(size, 1.0F, 9);
        types::DepthMap reference{before.disparity_px.clone(), before.sigma_disparity_px.clone()};
        int num_changed = 0;
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x) {
                float& disparity = reference.disparity_px.at<float>(y, x);
                float& sigma = reference.sigma_disparity_px.at<float>(y, x);
                const Estimate result = expected({disparity, sigma}, half_at(half, x, y));
                num_changed += result.sigma_px == sigma ? 0 : 1;
                disparity = result.disparity_px;
                sigma = result.sigma_px;
            }
        ASSERT_GT(num_changed, size.area() / 8);
        ASSERT_LT(num_changed, size.area());
        for (const auto set : {base::Instructions::Baseline, base::best_instructions()}) {
            types::DepthMap depth{before.disparity_px.clone(), before.sigma_disparity_px.clone()};
            combine_scales(half, depth, set);
            EXPECT_EQ(cv::norm(depth.disparity_px, reference.disparity_px, cv::NORM_INF), 0.0);
            EXPECT_EQ(
                cv::norm(depth.sigma_disparity_px, reference.sigma_disparity_px, cv::NORM_INF),
                0.0);
        }
    }
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
