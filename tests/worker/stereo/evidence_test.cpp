// The images determine where there is a disparity and how large its sigma is: up to the border, and
// also where the texture is so weak that only a wide window shows it.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kFirstColumn = 70;  // to the right of all disparities

double slanted(double x, double y) { return 14.0 + 0.05 * x + 0.03 * y; }

types::DepthMap match(const WarpedPair& pair, int num_scales) {
    types::RectifiedFrame frame;
    frame.left = pair.left;
    frame.right = pair.right;
    return StereoMatcher("sgm", 64, num_scales).match(frame);
}

// By the number of scales.
class Evidence : public testing::TestWithParam<int> {};

TEST_P(Evidence, SeesASurfaceUpToTheBorder) {
    const WarpedPair pair = make_warped_pair(slanted);
    const types::DepthMap depth = match(pair, GetParam());
    cv::Mat border(pair.left.size(), CV_8U, cv::Scalar(255));
    border(cv::Rect(kFirstColumn, 4, pair.left.cols - kFirstColumn - 4, pair.left.rows - 8))
        .setTo(0);
    border.colRange(0, kFirstColumn).setTo(0);
    const cv::Mat known = border & (depth.disparity_px > 0.0F);
    const cv::Mat good = known & (cv::abs(depth.disparity_px - pair.disparity_px) < 1.0F);
    EXPECT_GT(cv::countNonZero(known), 0.9 * cv::countNonZero(border));
    EXPECT_GT(cv::countNonZero(good), 0.98 * cv::countNonZero(known));
}

TEST_P(Evidence, TellsHowLittleWeakTextureSaysOfADisparity) {
    WarpedPairOptions options;
    options.contrast = 0.03;
    options.noise = 1.0;
    const WarpedPair pair = make_warped_pair(slanted, options);
    const types::DepthMap depth = match(pair, GetParam());
    double sum = 0.0;
    int num = 0;
    int num_wrong = 0;
    for (int y = 0; y < pair.left.rows; ++y)
        for (int x = kFirstColumn; x < pair.left.cols; ++x) {
            const double sigma = depth.sigma_disparity_px.at<float>(y, x);
            if (sigma < 1.0) continue;  // determined by a narrow window
            const double error =
                depth.disparity_px.at<float>(y, x) - pair.disparity_px.at<float>(y, x);
            ++num;
            if (std::abs(error) > 3.0 * sigma)
                ++num_wrong;
            else
                sum += error * error / (sigma * sigma);
        }
    EXPECT_GT(num, GetParam() == 1 ? 5000 : 3000);  // half the size makes many certain
    EXPECT_LT(num_wrong, 0.02 * num);
    // Sigma is larger than these errors, as it covers wrong winners at silhouettes too.
    EXPECT_GT(std::sqrt(sum / num), 1.0 / 3.0);
    EXPECT_LT(std::sqrt(sum / num), 1.5);
}

INSTANTIATE_TEST_SUITE_P(Scales, Evidence, testing::Values(1, 2));

}  // namespace
}  // namespace divemesh::stereo
