#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stereo/census_sgm.hpp"
#include "worker/stereo/coarse_disparity_search.hpp"
#include "worker/stereo/disparity_search_range.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::stereo {
namespace {

double slanted(double x, double y) { return 40.0 + 0.05 * x + 0.03 * y; }

types::Features features_from(double min_px, double max_px, int num) {
    types::Features features;
    for (int i = 0; i < num; ++i)
        features.push_back(
            {i, Eigen::Vector2d::Zero(), min_px + (max_px - min_px) * i / (num - 1)});
    return features;
}

TEST(DisparitySearchRange, ContainsTheFeaturesWithAMargin) {
    const types::DisparityRange range =
        disparity_search_range(features_from(40.0, 60.0, 100), 256, 640);
    EXPECT_EQ(range.num_px, 64);
    EXPECT_LE(range.first_px, 30);
    EXPECT_GE(range.first_px + range.num_px, 80);
}

TEST(DisparitySearchRange, IsTheFullRangeIfFeaturesAreFewOrFarApart) {
    EXPECT_EQ(disparity_search_range(features_from(40.0, 60.0, 20), 128, 640).num_px, 128);
    EXPECT_EQ(disparity_search_range(features_from(5.0, 90.0, 100), 128, 640).num_px, 128);
    EXPECT_EQ(disparity_search_range({}, 96, 640).num_px, 96);
}

TEST(DisparitySearchRange, StaysWithinTheFullRange) {
    const types::DisparityRange near =
        disparity_search_range(features_from(110.0, 126.0, 100), 128, 640);
    EXPECT_EQ(near.first_px + near.num_px, 128);
    EXPECT_EQ(disparity_search_range(features_from(2.0, 10.0, 100), 128, 640).first_px, 0);
}

TEST(DisparitySearchRange, ReachesNearFeaturesOfLargeImages) {
    const types::DisparityRange near =
        disparity_search_range(features_from(150.0, 180.0, 100), 128, 1280);
    EXPECT_LE(near.first_px, 112);
    EXPECT_GE(near.first_px + near.num_px, 240);
    EXPECT_LT(near.num_px, 320);
    EXPECT_EQ(disparity_search_range(features_from(10.0, 290.0, 100), 128, 1280).num_px, 320);
    EXPECT_EQ(disparity_search_range(features_from(150.0, 180.0, 20), 128, 1280).num_px, 128)
        << "few features";
}

TEST(CensusSgm, FindsTheSameWithinARangeThatHoldsTheSurface) {
    const WarpedPair pair = make_warped_pair(slanted);  // 40 to 63 px
    CensusSgm matcher(128);
    const cv::Mat whole = matcher.compute(pair.left, pair.right);
    const cv::Mat part = matcher.compute(pair.left, pair.right, {20, 64});
    cv::Mat differs = cv::abs(whole - part) > 1.0F;
    differs.colRange(0, 100).setTo(0);
    EXPECT_LT(cv::countNonZero(differs), differs.total() / 200);
}

// Returns the disparity of a floor at 20 px with a block at 90 px in front of it, in the middle
// third.
double block_on_floor(double x, double) { return x > 213.0 && x < 427.0 ? 90.0 : 20.0; }

const WarpedPairOptions kLarge{.width_px = 640, .height_px = 480};

TEST(CoarseDisparitySearch, FindsWhereThePatchesLie) {
    const WarpedPair pair = make_warped_pair(block_on_floor, kLarge);
    const auto patches = CoarseDisparitySearch(128).survey(pair.left, pair.right);
    ASSERT_GT(patches.size(), 8'000U);  // of 160 x 120
    const auto around = [&](float px) {
        return std::count_if(
            patches.begin(), patches.end(), [&](float d) { return std::abs(d - px) < 4.0F; });
    };
    EXPECT_GT(around(20.0F) + around(90.0F), std::ssize(patches) * 19 / 20);
    EXPECT_NEAR(
        static_cast<double>(around(90.0F)) / static_cast<double>(patches.size()), 1.0 / 3.0, 0.12);
}

TEST(CoarseDisparitySearch, CountsWhatNoSearchWithinTheRangeCanFind) {
    const WarpedPair pair = make_warped_pair([](double, double) { return 60.0; }, kLarge);
    const auto patches = CoarseDisparitySearch(128).survey(pair.left, pair.right);
    const types::SearchOutcome too_near = outcome_of({9, 32}, patches);
    EXPECT_GT(too_near.num_patches, 8'000);
    EXPECT_GT(100 * too_near.num_too_near, 98 * too_near.num_patches);
    EXPECT_EQ(too_near.num_too_far, 0);
    const types::SearchOutcome too_far = outcome_of({80, 48}, patches);
    EXPECT_GT(100 * too_far.num_too_far, 98 * too_far.num_patches);
    const types::SearchOutcome held = outcome_of({32, 64}, patches);
    EXPECT_LT(held.num_too_near + held.num_too_far, held.num_patches / 50);
}

TEST(CoarseDisparitySearch, FindsDisparitiesBeyondTheFullRange) {
    const WarpedPair pair = make_warped_pair([](double, double) { return 100.0; }, kLarge);
    const auto patches = CoarseDisparitySearch(64).survey(pair.left, pair.right);
    const types::SearchOutcome outcome = outcome_of({0, 64}, patches);
    EXPECT_GT(outcome.num_patches, 8'000);
    EXPECT_GT(100 * outcome.num_too_near, 98 * outcome.num_patches);
}

TEST(CoarseDisparitySearch, WidensARangeToHoldWhatItShows) {
    std::vector<float> patches(1'000, 30.0F);
    const auto holds = [](const types::DisparityRange& range, int px) {
        return range.first_px < px && px < range.first_px + range.num_px - 1;
    };
    const types::DisparityRange narrow{10, 64};
    EXPECT_EQ(widen(narrow, patches, 256).num_px, 64);
    EXPECT_EQ(widen(narrow, {}, 256).first_px, 10);
    std::fill(patches.end() - 10, patches.end(), 200.0F);  // one in a hundred may be wrong
    EXPECT_EQ(widen(narrow, patches, 256).num_px, 64);
    std::fill(patches.end() - 100, patches.end(), 120.0F);
    EXPECT_TRUE(holds(widen(narrow, patches, 256), 30));
    EXPECT_TRUE(holds(widen(narrow, patches, 256), 120));
    EXPECT_LT(widen(narrow, patches, 256).num_px, 256);
    EXPECT_EQ(widen(narrow, patches, 96).num_px, 96);
    std::fill(patches.begin(), patches.begin() + 100, 5.0F);
    const types::DisparityRange both = widen({20, 64}, patches, 256);
    EXPECT_TRUE(holds(both, 5) && holds(both, 120));
}

// With features on the floor alone, the estimated range excludes the block.
TEST(StereoMatcher, FindsWhatTheRangeLeavesOut) {
    const WarpedPair pair = make_warped_pair(block_on_floor, kLarge);
    for (const std::string stereo : {"sgm", "block", "opencv_sgbm"}) {
        const types::DepthMap depth =
            StereoMatcher(stereo, 128).match({0, 0, pair.left, pair.right}, {0, 64});
        EXPECT_EQ(depth.search.range.num_px, 128) << stereo;
        EXPECT_GT(depth.search.num_patches, 8'000) << stereo;
        EXPECT_LT(depth.search.num_too_near, depth.search.num_patches / 50) << stereo;
        const cv::Rect block(240, 20, 160, 440);
        const cv::Mat found = cv::abs(depth.disparity_px(block) - 90.0F) < 1.0F;
        EXPECT_GT(cv::countNonZero(found), block.area() * 2 / 3) << stereo;
    }
}

TEST(StereoMatcher, TellsWhatIsTooNearForAllItSearches) {
    const WarpedPair pair = make_warped_pair(block_on_floor, kLarge);
    const types::DepthMap depth = StereoMatcher("sgm", 64).match({0, 0, pair.left, pair.right});
    EXPECT_NEAR(static_cast<double>(depth.search.num_too_near) /
                    static_cast<double>(depth.search.num_patches),
                1.0 / 3.0,
                0.12);
}

// A surface at 200 px in an image of 1280 px is as near as one at 100 px in 640.
TEST(StereoMatcher, SearchesLargeImagesAsNearAsSmallOnes) {
    EXPECT_EQ(types::max_disparities_px(128, 640), 128);
    EXPECT_EQ(types::max_disparities_px(128, 1280), 320);
    EXPECT_EQ(types::max_disparities_px(128, 1920), 512);
    EXPECT_EQ(types::max_disparities_px(256, 640), 256);
    const auto near_block = [](double x, double) { return x > 500.0 && x < 900.0 ? 200.0 : 40.0; };
    const WarpedPair pair = make_warped_pair(near_block, {.width_px = 1280, .height_px = 240});
    const types::DepthMap depth =
        StereoMatcher("sgm", 128).match({0, 0, pair.left, pair.right}, {0, 128});
    EXPECT_EQ(depth.search.num_too_near, 0);
    const cv::Mat found = cv::abs(depth.disparity_px(cv::Rect(520, 10, 360, 220)) - 200.0F) < 1.0F;
    EXPECT_GT(cv::countNonZero(found), 360 * 220 * 9 / 10);
}

// Returns a strip of 1920 px: a block at `near_px` on a floor at 100 px. The full size searches 512
// px, half the size 768.
types::DepthMap match_near_block(double near_px) {
    const auto block = [&](double x, double) { return x > 1200.0 && x < 1700.0 ? near_px : 100.0; };
    const WarpedPair pair = make_warped_pair(block, {.width_px = 1920, .height_px = 240});
    return StereoMatcher("sgm", 128, 2).match({0, 0, pair.left, pair.right}, {0, 128});
}

TEST(StereoMatcher, MeasuresWhatOnlyHalfTheSizeReaches) {
    const types::DepthMap depth = match_near_block(600.0);
    EXPECT_LT(50 * depth.search.num_too_near, depth.search.num_patches);
    const cv::Rect inside(1260, 20, 380, 200);
    const cv::Mat found = cv::abs(depth.disparity_px(inside) - 600.0F) < 2.0F;
    EXPECT_GT(cv::countNonZero(found), inside.area() / 2);
}

TEST(StereoMatcher, TellsWhatIsTooNearForHalfTheSize) {
    const types::DepthMap depth = match_near_block(800.0);
    EXPECT_GT(10 * depth.search.num_too_near, depth.search.num_patches);
}

TEST(CensusSgm, EveryInstructionSetGivesTheSameWithinARange) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    const WarpedPair pair = make_warped_pair(slanted);
    const auto within = [&](base::Instructions set) {
        return CensusSgm(128, set).compute(pair.left, pair.right, {27, 64});
    };
    for (int set = 1; set <= static_cast<int>(base::best_instructions()); ++set)
        EXPECT_EQ(cv::norm(within(base::Instructions::Baseline),
                           within(static_cast<base::Instructions>(set)),
                           cv::NORM_INF),
                  0.0);
}

}  // namespace
}  // namespace divemesh::stereo
