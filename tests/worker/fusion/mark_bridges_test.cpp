#include "worker/fusion/mark_bridges.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace divemesh::fusion {
namespace {

constexpr int kWidth_px = 160;
constexpr int kHeight_px = 120;
constexpr double kFocal_px = 500.0;
constexpr double kBaseline_m = 0.12;
constexpr float kRim_px = 5.0F;
constexpr float kSigma_px = 0.1F;

cv::Mat map_of(const std::function<double(int x, int y)>& disparity_px) {
    cv::Mat map(kHeight_px, kWidth_px, CV_32F);
    for (int y = 0; y < map.rows; ++y)
        for (int x = 0; x < map.cols; ++x)
            map.at<float>(y, x) = static_cast<float>(disparity_px(x, y));
    return map;
}

// Returns 255 at the pixels on bridges.
cv::Mat bridges(const cv::Mat& disparity_px,
                base::Instructions instructions = base::best_instructions()) {
    const cv::Mat sigma_px(disparity_px.size(), CV_32F, cv::Scalar(kSigma_px));
    cv::Mat rim_px(disparity_px.size(), CV_32F, cv::Scalar(kRim_px));
    mark_bridges(disparity_px, sigma_px, kFocal_px, instructions, rim_px);
    return rim_px == 0.0F;
}

// Ground below a level camera: row y lies y + 20 px below the horizon, so that the last row is seen
// at 16 degrees and the first at 2.
double ground_px(int y, double height_m) { return kBaseline_m * (y + 20) / height_m; }

// A plate's upper edge in row 60, before ground that continues 0.8 m behind it; smoothed over
// `width_px` pixels, as windows do.
cv::Mat edge(int width_px) {
    const cv::Mat sharp = map_of([](int, int y) {
        return y < 60 ? kFocal_px * kBaseline_m / 3.4 : kFocal_px * kBaseline_m / 2.6;
    });
    cv::Mat smooth;
    cv::blur(sharp, smooth, {1, width_px}, {-1, -1}, cv::BORDER_REPLICATE);
    return smooth;
}

TEST(MarkBridges, GroundIsNoBridgeAtAnyAngle) {
    for (const double height_m : {0.3, 1.0, 3.0})
        EXPECT_EQ(
            cv::countNonZero(bridges(map_of([&](int, int y) { return ground_px(y, height_m); }))),
            0)
            << height_m << " m above the ground";
}

TEST(MarkBridges, ASpreadStepIsOneAndTheSurfacesBesideItAreNot) {
    for (const int width_px : {3, 5, 7}) {
        const cv::Mat marked = bridges(edge(width_px));
        for (int y = 0; y < kHeight_px; ++y) {
            const int num = cv::countNonZero(marked.row(y));
            // Within 2 px of the edge every pixel has it between its ends; the frame is left out.
            const int half_px_from_edge = std::abs(2 * y - 119);
            if (half_px_from_edge <= 4) {
                EXPECT_EQ(num, kWidth_px - 20) << "row " << y << ", step over " << width_px;
            } else if (half_px_from_edge > 20) {
                EXPECT_EQ(num, 0) << "row " << y << ", step over " << width_px;
            }
        }
    }
}

TEST(MarkBridges, StepsAlongARowAreFoundToo) {
    const cv::Mat marked = bridges(edge(5)(cv::Rect(0, 0, 120, 120)).t());
    EXPECT_GT(cv::countNonZero(marked.col(60)), 90);
}

TEST(MarkBridges, AStepBesideUnknownPixelsIsNotJudged) {
    cv::Mat disparity_px = edge(5);
    disparity_px.rowRange(0, 52).setTo(0.0F);
    EXPECT_EQ(cv::countNonZero(bridges(disparity_px).rowRange(58, 62)), 0);
}

TEST(MarkBridges, NoiseOfTheStatedSigmaTakesFewPixels) {
    cv::Mat disparity_px = map_of([](int, int y) { return ground_px(y, 1.0); });
    cv::Mat noise(disparity_px.size(), CV_32F);
    cv::RNG random(3);
    random.fill(noise, cv::RNG::NORMAL, 0.0, kSigma_px);
    disparity_px += noise;
    // The change is 0.96 px with 0.14 px of noise, and has to be twice the larger of two changes of
    // 0.72 px with as much: three standard deviations more.
    EXPECT_LT(cv::countNonZero(bridges(disparity_px)), kWidth_px * kHeight_px * 3 / 100);
}

TEST(MarkBridges, InstructionSetsAgree) {
    cv::Mat disparity_px = edge(7);
    disparity_px.at<float>(40, 70) = 0.0F;
    EXPECT_EQ(cv::countNonZero(bridges(disparity_px, base::Instructions::Baseline) !=
                               bridges(disparity_px, base::Instructions::Avx2)),
              0);
}

}  // namespace
}  // namespace divemesh::fusion
