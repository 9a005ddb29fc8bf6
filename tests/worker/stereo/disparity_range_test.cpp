#include <gtest/gtest.h>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/steps/choose_range.hpp"
#include "worker/stereo/census_sgm.hpp"

namespace divemesh::worker {
namespace {

double slanted(double x, double y) { return 40.0 + 0.05 * x + 0.03 * y; }

Features features_from(double least_px, double largest_px, int num) {
    Features features;
    for (int i = 0; i < num; ++i)
        features.push_back(
            {i, Eigen::Vector2d::Zero(), least_px + (largest_px - least_px) * i / (num - 1)});
    return features;
}

TEST(ChooseRange, HoldsTheFeaturesWithRoomAroundThem) {
    const DisparityRange range = choose_range(features_from(40.0, 60.0, 100), 256);
    EXPECT_EQ(range.num_px, 64);
    EXPECT_LE(range.first_px, 30);
    EXPECT_GE(range.first_px + range.num_px, 80);
}

TEST(ChooseRange, IsTheWholeOneWhereFeaturesAreFewOrFarApart) {
    EXPECT_EQ(choose_range(features_from(40.0, 60.0, 20), 128).num_px, 128);
    EXPECT_EQ(choose_range(features_from(5.0, 90.0, 100), 128).num_px, 128);
    EXPECT_EQ(choose_range({}, 96).num_px, 96);
}

TEST(ChooseRange, StaysWithinTheWholeOne) {
    const DisparityRange near = choose_range(features_from(110.0, 126.0, 100), 128);
    EXPECT_EQ(near.first_px + near.num_px, 128);
    EXPECT_EQ(choose_range(features_from(2.0, 10.0, 100), 128).first_px, 0);
}

TEST(CensusSgm, FindsTheSameWithinARangeThatHoldsTheSurface) {
    const WarpedPair pair = make_warped_pair(slanted);  // 40 to 63 px
    CensusSgm matcher(128);
    const cv::Mat whole = matcher.compute(pair.left, pair.right);
    const cv::Mat part = matcher.compute(pair.left, pair.right, {20, 64});
    cv::Mat differs = cv::abs(whole - part) > 1.0F;
    differs.colRange(0, 100).setTo(0);
    EXPECT_LT(cv::countNonZero(differs), differs.total() / 200);
    EXPECT_LT(matcher.outcome().num_clipped, matcher.outcome().num_clear / 40);
}

TEST(CensusSgm, CountsWhatARangeCutsOff) {
    const WarpedPair pair = make_warped_pair([](double, double) { return 40.5; });
    CensusSgm matcher(128);
    matcher.compute(pair.left, pair.right, {9, 32});  // 40 is the last
    EXPECT_GT(matcher.outcome().num_clear, 20'000);
    EXPECT_GT(10 * matcher.outcome().num_clipped, 9 * matcher.outcome().num_clear);
}

TEST(CensusSgm, EveryInstructionSetGivesTheSameWithinARange) {
    const WarpedPair pair = make_warped_pair(slanted);
    const auto within = [&](Instructions set) {
        return CensusSgm(128, set).compute(pair.left, pair.right, {27, 64});
    };
    for (int set = 1; set <= static_cast<int>(best_instructions()); ++set)
        EXPECT_EQ(cv::norm(within(Instructions::Baseline),
                           within(static_cast<Instructions>(set)),
                           cv::NORM_INF),
                  0.0);
}

}  // namespace
}  // namespace divemesh::worker
