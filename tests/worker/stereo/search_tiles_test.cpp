#include "worker/stereo/search_tiles.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stereo/census_sgm.hpp"
#include "worker/stereo/match_stereo.hpp"
#include "worker/stereo/single_scale_matcher.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kWidth_px = 1280;
constexpr int kHeight_px = 512;
constexpr types::DisparityRange kWhole{0, 384};

// A bed that comes nearer from left to right, with a column on it.
double bed_with_a_column(double x, double y) {
    const bool on_column = x > 700.0 && x < 780.0 && y > 100.0;
    return on_column ? 260.0 : 30.0 + 0.15 * x + 0.02 * y;
}

cv::Mat half_of(const std::function<double(double x, double y)>& disparity) {
    cv::Mat half(kHeight_px / 2, kWidth_px / 2, CV_32F);
    for (int y = 0; y < half.rows; ++y)
        for (int x = 0; x < half.cols; ++x)
            half.at<float>(y, x) = static_cast<float>(0.5 * disparity(2.0 * x, 2.0 * y));
    return half;
}

double cost_of(const std::vector<SearchTile>& tiles) {
    double cost = 0.0;
    for (const SearchTile& tile : tiles)
        cost += static_cast<double>(with_surroundings(tile.part, {kWidth_px, kHeight_px}).area()) *
                tile.range.num_px;
    return cost;
}

TEST(SearchTilesTest, CoverTheImageOnceAndContainWhatTheHalfSizeSaw) {
    const auto tiles = search_tiles(half_of(bed_with_a_column), {kWidth_px, kHeight_px}, kWhole);
    ASSERT_GT(tiles.size(), 1U);
    EXPECT_LT(cost_of(tiles), 0.6 * kWidth_px * kHeight_px * kWhole.num_px);
    cv::Mat times(kHeight_px, kWidth_px, CV_8U, cv::Scalar(0));
    for (const SearchTile& tile : tiles) {
        times(tile.part) += 1;
        EXPECT_GE(tile.range.first_px, kWhole.first_px);
        EXPECT_LE(tile.range.first_px + tile.range.num_px, kWhole.first_px + kWhole.num_px);
        for (const cv::Point corner : {tile.part.tl(), tile.part.br() - cv::Point(1, 1)}) {
            const double truth_px = bed_with_a_column(corner.x, corner.y);
            EXPECT_GT(truth_px, tile.range.first_px + 4);
            EXPECT_LT(truth_px, tile.range.first_px + tile.range.num_px - 5);
        }
    }
    EXPECT_EQ(cv::countNonZero(times != 1), 0);
}

TEST(SearchTilesTest, ARangeHoldsAllButFewDisparitiesInWhateverOrderTheyLie) {
    cv::Mat half(kHeight_px / 2, kWidth_px / 2, CV_32F);
    cv::RNG(9).fill(half, cv::RNG::UNIFORM, 40.0, 70.0);  // 80 to 140 px of the whole size
    for (const SearchTile& tile : search_tiles(half, {kWidth_px, kHeight_px}, kWhole)) {
        EXPECT_LE(tile.range.first_px, 80 - 12);
        EXPECT_GE(tile.range.first_px + tile.range.num_px, 140 + 12);
        EXPECT_EQ(tile.range.num_px, 128);  // of 60, the margins and the step
    }
}

TEST(SearchTilesTest, WhereTheHalfSizeSawLittleTheWholeRangeIsSearched) {
    cv::Mat half = half_of(bed_with_a_column);
    half.colRange(0, half.cols / 2).setTo(0.0F);
    int num_unknown = 0;
    for (const SearchTile& tile : search_tiles(half, {kWidth_px, kHeight_px}, kWhole)) {
        if (tile.part.br().x > kWidth_px / 2 - 64) continue;
        EXPECT_EQ(tile.range.num_px, kWhole.num_px);
        ++num_unknown;
    }
    EXPECT_GT(num_unknown, 0);
    half.setTo(0.0F);
    const auto tiles = search_tiles(half, {kWidth_px, kHeight_px}, kWhole);
    ASSERT_EQ(tiles.size(), 1U);
    EXPECT_EQ(tiles[0].range.num_px, kWhole.num_px);
}

TEST(SearchTilesTest, TilesThatSaveNothingAreNotMade) {
    const auto tiles = search_tiles(
        half_of([](double, double y) { return 8.0 + 0.1 * y; }), {kWidth_px, kHeight_px}, {0, 96});
    EXPECT_EQ(tiles.size(), 1U);
}

TEST(SearchTilesTest, MatchingByTilesIsAsRightAsWithTheWholeRange) {
    WarpedPairOptions options;
    options.width_px = kWidth_px;
    options.height_px = kHeight_px;
    const WarpedPair pair = make_warped_pair(bed_with_a_column, options);
    CensusSgm matcher(kWhole.num_px);
    const cv::Mat whole = matcher.compute(pair.left, pair.right, kWhole);
    const cv::Mat by_tiles =
        matcher.compute(pair.left,
                        pair.right,
                        search_tiles(half_of(bed_with_a_column), pair.left.size(), kWhole),
                        CensusSgm::kMinTolerance);
    const auto error_whole = compare_disparity(whole, pair.disparity_px, kWhole.num_px - 1);
    const auto error_tiles = compare_disparity(by_tiles, pair.disparity_px, kWhole.num_px - 1);
    EXPECT_GE(error_tiles.density, error_whole.density - 0.002);
    EXPECT_LE(error_tiles.bad1, error_whole.bad1 + 0.0005);
    EXPECT_LT(error_tiles.bad1, 0.01);
    EXPECT_LT(error_tiles.median_px, 0.2);
    const cv::Mat both = (whole > 0.0F) & (by_tiles > 0.0F);
    cv::Mat difference;
    cv::absdiff(whole, by_tiles, difference);
    EXPECT_LT(cv::countNonZero(both & (difference > 0.5F)), cv::countNonZero(both) / 1000);
}

// Without the half size's tiles one scale would take longer than two.
TEST(SearchTilesTest, TheMatcherUsesThemWithOneScaleToo) {
    WarpedPairOptions options;
    options.width_px = kWidth_px;
    options.height_px = kHeight_px;
    const WarpedPair pair = make_warped_pair(bed_with_a_column, options);
    const types::RectifiedFrame frame{0, 0, pair.left, pair.right};
    const types::DepthMap found = StereoMatcher("sgm", kWhole.num_px, 1).match(frame);
    EXPECT_EQ(found.search.range.num_px, kWhole.num_px);

    types::RectifiedFrame half;
    cv::resize(pair.left, half.left, {kWidth_px / 2, kHeight_px / 2}, 0.0, 0.0, cv::INTER_AREA);
    cv::resize(pair.right, half.right, half.left.size(), 0.0, 0.0, cv::INTER_AREA);
    const cv::Mat half_px =
        SingleScaleMatcher("sgm", kWhole.num_px).match(half, {0, kWhole.num_px / 2}).disparity_px;
    const auto tiles = search_tiles(half_px, pair.left.size(), kWhole);
    ASSERT_GT(tiles.size(), 1U);
    const types::DepthMap by_tiles = SingleScaleMatcher("sgm", kWhole.num_px).match(frame, tiles);
    EXPECT_EQ(cv::norm(found.disparity_px, by_tiles.disparity_px, cv::NORM_INF), 0.0);
    const auto error = compare_disparity(found.disparity_px, pair.disparity_px, kWhole.num_px - 1);
    EXPECT_GT(error.density, 0.8);
    EXPECT_LT(error.bad1, 0.02);
}

}  // namespace
}  // namespace divemesh::stereo
