#include "worker/stereo/weak_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::stereo {
namespace {

// A board of 320 x 240 px at `slope` px per px, measured around a gap, and winners everywhere.
struct Board {
    explicit Board(cv::Rect gap, float slope) : disparity_px(240, 320, CV_32F) {
        for (int y = 0; y < 240; ++y)
            for (int x = 0; x < 320; ++x)
                disparity_px.at<float>(y, x) = 30.0F + slope * static_cast<float>(x);
        truth_px = disparity_px.clone();
        winners_px = disparity_px.clone();
        disparity_px(gap).setTo(0.0);
        sigma_px = cv::Mat(240, 320, CV_32F, cv::Scalar(0.15));
    }
    cv::Mat disparity_px, truth_px, winners_px, sigma_px;
};

TEST(WeakSurface, ContinuesAMeasuredPlaneThroughAGap) {
    const cv::Rect gap(150, 100, 24, 24);
    Board board(gap, 0.1F);
    board.winners_px(gap) *= -1.0;  // unconfirmed
    WeakSurface().add(board.winners_px, board.disparity_px, board.sigma_px);
    EXPECT_LT(cv::norm(board.disparity_px, board.truth_px, cv::NORM_INF), 0.1);
    EXPECT_GT(board.sigma_px.at<float>(112, 162), 0.5F);
    EXPECT_EQ(board.sigma_px.at<float>(10, 10), 0.15F);
}

TEST(WeakSurface, LeavesAGapWhereTheWinnersSeeSomethingElse) {
    const cv::Rect gap(150, 100, 24, 24);
    Board board(gap, 0.1F);
    board.winners_px(gap).setTo(12.0);  // far behind, as through a window
    WeakSurface().add(board.winners_px, board.disparity_px, board.sigma_px);
    EXPECT_EQ(board.disparity_px.at<float>(112, 162), 0.0F);
}

TEST(WeakSurface, AddsNothingBesideASurfaceThatEnds) {
    Board board(cv::Rect(0, 0, 320, 120), 0.0F);  // open water above a bed
    WeakSurface().add(board.winners_px, board.disparity_px, board.sigma_px);
    EXPECT_EQ(cv::countNonZero(board.disparity_px.rowRange(0, 120)), 0);
}

// The texture is hidden by a blank disc, as on a painted hull: only what lies around shows where it
// is.
TEST(StereoMatcher, ClosesABlankSpotOnASurface) {
    const auto slanted = [](double x, double y) { return 14.0 + 0.05 * x + 0.03 * y; };
    WarpedPair pair = make_warped_pair(slanted);
    cv::Mat spot(pair.left.size(), CV_8U, cv::Scalar(0));
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 320; ++x) {
            const double d = slanted(x, y);
            if (std::hypot(x - 200.0, y - 120.0) >= 12.0) continue;
            spot.at<std::uint8_t>(y, x) = 255;
            pair.left.at<std::uint8_t>(y, x) = 128;
            pair.right.at<std::uint8_t>(y, static_cast<int>(std::lround(x - d))) = 128;
        }
    types::RectifiedFrame frame;
    frame.left = pair.left;
    frame.right = pair.right;
    const types::DepthMap depth = StereoMatcher("sgm", 64).match(frame);
    const cv::Mat good = spot & (cv::abs(depth.disparity_px - pair.disparity_px) < 1.0F);
    EXPECT_GT(cv::countNonZero(good), 0.9 * cv::countNonZero(spot));
}

}  // namespace
}  // namespace divemesh::stereo
