#include "worker/features/epipolar_search.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "tests/synthetic/texture.hpp"

namespace divemesh::features {
namespace {

TEST(EpipolarSearchTest, FindsTheDisparityUnderOtherLight) {
    const cv::Mat left = synthetic::textured_image(0.0, 0.0);
    const cv::Mat right = synthetic::textured_image(-23.0, 0.0, 0.9, 90.0);
    EpipolarSearch search(base::Instructions::Baseline);
    int num_found = 0;
    for (int u = 40; u < 300; u += 7) {
        const int disparity = search.find(left, right, u, 100, 64);
        if (disparity == 0) continue;
        ++num_found;
        EXPECT_NEAR(disparity, 23, 1) << "column " << u;
    }
    EXPECT_GE(num_found, 30);
}

TEST(EpipolarSearchTest, EveryInstructionSetFindsTheSame) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    const cv::Mat left = synthetic::textured_image(0.0, 0.0);
    const cv::Mat right = synthetic::textured_image(-23.0, 0.0, 0.9, 90.0);
    EpipolarSearch baseline(base::Instructions::Baseline);
    EpipolarSearch best(base::best_instructions());
    int num_found = 0;
    for (int u = 40; u < 300; u += 7) {
        const int disparity = baseline.find(left, right, u, 100, 64);
        EXPECT_EQ(disparity, best.find(left, right, u, 100, 64));
        num_found += disparity == 0 ? 0 : 1;
    }
    EXPECT_GE(num_found, 30);
}

TEST(EpipolarSearchTest, FindsNothingWhereTheRowRepeatsItselfOrTheSquareLeavesTheImage) {
    cv::Mat stripes(240, 320, CV_8U);
    for (int v = 0; v < stripes.rows; ++v)
        for (int u = 0; u < stripes.cols; ++u)
            stripes.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(u % 16 < 8 ? 60 : 180);
    EpipolarSearch search;
    EXPECT_EQ(search.find(stripes, stripes, 200, 100, 64), 0);
    const cv::Mat image = synthetic::textured_image(0.0, 0.0);
    EXPECT_EQ(search.find(image, image, 4, 100, 64), 0);
    EXPECT_EQ(search.find(image, image, 100, 236, 64), 0);
}

}  // namespace
}  // namespace divemesh::features
