#include "worker/features/corner_scores.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/texture.hpp"

namespace divemesh::features {
namespace {

cv::Mat inner(const cv::Mat& image) {
    constexpr int kBorder = CornerScores::kBorder_px;
    return image(cv::Rect(kBorder, kBorder, image.cols - 2 * kBorder, image.rows - 2 * kBorder));
}

TEST(CornerScoresTest, AreThoseOfOpenCv) {
    const cv::Mat image = synthetic::textured_image(0.0, 0.0);
    cv::Mat expected;
    cv::cornerMinEigenVal(image, expected, 5);
    // OpenCV divides the Sobel sums by 4 * block * 255 and adds over the block.
    expected *= 20.0 * 20.0 * 255.0 * 255.0 / (64.0 * 25.0);
    double largest = 0.0;
    cv::minMaxLoc(inner(expected), nullptr, &largest);

    CornerScores scores;
    const cv::Mat& own = scores.of(image);

    EXPECT_LT(cv::norm(inner(own), inner(expected), cv::NORM_INF), 1e-4 * largest);
    EXPECT_EQ(own.at<float>(2, 100), 0.0F);
}

TEST(CornerScoresTest, EveryImageStartsAnew) {
    CornerScores used;
    CornerScores fresh;
    used.of(synthetic::textured_image(5.0, 3.0));
    const cv::Mat image = synthetic::textured_image(0.0, 0.0);
    EXPECT_EQ(cv::norm(used.of(image), fresh.of(image), cv::NORM_INF), 0.0);
}

TEST(CornerScoresTest, EveryInstructionSetGivesTheSameScores) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    CornerScores baseline(base::Instructions::Baseline);
    CornerScores best(base::best_instructions());
    const cv::Mat image = synthetic::textured_image(0.0, 0.0);
    EXPECT_EQ(cv::norm(baseline.of(image), best.of(image), cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace divemesh::features
