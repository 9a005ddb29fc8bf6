#include "worker/stereo/match_stereo.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/paths.hpp"
#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stereo/block_matcher.hpp"
#include "worker/stereo/census_sgm.hpp"
#include "worker/stereo/disparity_sigma.hpp"
#include "worker/stereo/fill_holes.hpp"
#include "worker/stereo/refine_disparity.hpp"
#include "worker/stereo/smooth_on_plane.hpp"
#include "worker/stereo/speckles.hpp"

namespace divemesh::stereo {
namespace {

double slanted(double x, double y) { return 14.0 + 0.05 * x + 0.03 * y; }

types::DepthMap match(const std::string& matcher,
                      const cv::Mat& left,
                      const cv::Mat& right,
                      int num_disparities) {
    types::RectifiedFrame frame;
    frame.left = left;
    frame.right = right;
    return StereoMatcher(matcher, num_disparities).match(frame);
}

class EveryMatcher : public testing::TestWithParam<std::string> {};

TEST_P(EveryMatcher, FindsASlantedPlaneToAFractionOfAPixel) {
    const auto pair = make_warped_pair(slanted);
    const auto depth = match(GetParam(), pair.left, pair.right, 64);
    const auto error = compare_disparity(depth.disparity_px, pair.disparity_px, 63.0);
    EXPECT_GT(error.density, 0.8);
    EXPECT_LT(error.bad1, 0.005);
    EXPECT_LT(error.median_px, 0.2);
    EXPECT_LT(std::abs(error.mean_px), 0.05);
}

TEST_P(EveryMatcher, BearsAnotherGainAndBiasInTheRightCamera) {
    WarpedPairOptions options;
    options.right_gain = 0.9;
    options.right_bias = 8.0;
    const auto pair = make_warped_pair(slanted, options);
    const auto depth = match(GetParam(), pair.left, pair.right, 64);
    const auto error = compare_disparity(depth.disparity_px, pair.disparity_px, 63.0);
    EXPECT_GT(error.density, 0.75);
    EXPECT_LT(error.bad1, 0.01);
}

TEST_P(EveryMatcher, LeavesWaterWithoutTextureUnknown) {
    WarpedPairOptions options;
    options.contrast = 0.0;
    const auto pair = make_warped_pair(slanted, options);
    const auto depth = match(GetParam(), pair.left, pair.right, 64);
    EXPECT_LT(cv::countNonZero(depth.disparity_px > 0.0F), 320 * 240 / 100);
}

TEST_P(EveryMatcher, GivesAStandardDeviationWhereItGivesADisparity) {
    const auto pair = make_warped_pair(slanted);
    const auto depth = match(GetParam(), pair.left, pair.right, 64);
    const cv::Mat known = depth.disparity_px > 0.0F;
    EXPECT_EQ(cv::countNonZero(known != (depth.sigma_disparity_px > 0.0F)), 0);
}

INSTANTIATE_TEST_SUITE_P(Matchers,
                         EveryMatcher,
                         testing::Values("block", "opencv_sgbm", "sgm"),
                         [](const auto& matcher) { return matcher.param; });

TEST(BlockMatcher, EveryInstructionSetGivesTheSameIntegers) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    const auto pair = make_warped_pair(slanted);
    const cv::Mat a = BlockMatcher(64, base::Instructions::Baseline).compute(pair.left, pair.right);
    const cv::Mat b = BlockMatcher(64).compute(pair.left, pair.right);
    EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0);
}

TEST(RefineDisparity, EveryInstructionSetGivesTheSameBytes) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    const auto pair = make_warped_pair(slanted);
    cv::Mat a = CensusSgm(64).compute(pair.left, pair.right);
    cv::Mat b = a.clone();
    const cv::Mat sigma_a =
        DisparityRefiner(base::Instructions::Baseline).refine(pair.left, pair.right, a);
    const cv::Mat sigma_b = DisparityRefiner().refine(pair.left, pair.right, b);
    EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(sigma_a, sigma_b, cv::NORM_INF), 0.0);
}

// Raw winners cluster at whole pixels, which turns a ramp into steps. The slope of the ramp is 1/20
// px per pixel here, so a locked disparity is off by up to half a pixel.
TEST(RefineDisparity, FreesTheDisparityFromPixelLocking) {
    const auto pair = make_warped_pair(slanted);
    const cv::Mat raw = CensusSgm(64).compute(pair.left, pair.right);
    cv::Mat refined = raw.clone();
    DisparityRefiner().refine(pair.left, pair.right, refined);
    const auto before = compare_disparity(raw, pair.disparity_px, 63.0);
    const auto after = compare_disparity(refined, pair.disparity_px, 63.0);
    EXPECT_LT(after.median_px, 0.5 * before.median_px);
    EXPECT_LT(after.median_px, 0.06);
}

TEST(SmoothOnPlane, LeavesAnyPlaneAndEveryStepAsItIs) {
    cv::Mat disparity(40, 60, CV_32F);
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 60; ++x)
            disparity.at<float>(y, x) = 20.0F + 0.25F * static_cast<float>(x) -
                                        0.5F * static_cast<float>(y) + (x < 30 ? 0.0F : 9.0F);
    PaddedDisparity plane, smooth;
    plane.copy_from(disparity);
    smooth_on_plane(plane, 0.5F, smooth);
    EXPECT_LT(cv::norm(smooth.to_mat(), disparity, cv::NORM_INF), 1e-4);
}

TEST(FillHoles, BelievesWinnersThatTheSurfaceAroundThemSupports) {
    cv::Mat disparity(60, 80, CV_32F);
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 80; ++x)
            disparity.at<float>(y, x) = 20.0F + 0.25F * static_cast<float>(x);
    disparity.at<float>(30, 20) = -26.0F;              // within a pixel of the plane
    disparity.at<float>(30, 40) = -40.0F;              // far from it
    disparity.at<float>(30, 60) = 0.0F;                // no winner
    disparity(cv::Rect(0, 40, 80, 20)).setTo(-30.0F);  // open water beside the surface
    PaddedDisparity filled, spare;
    filled.copy_from(disparity);
    fill_holes(filled, spare);
    EXPECT_NEAR(filled.row(30)[20], 25.0F, 1e-3F);
    EXPECT_EQ(filled.row(30)[40], 0.0F);
    EXPECT_EQ(filled.row(30)[60], 0.0F);
    for (int x = 0; x < 80; ++x) EXPECT_EQ(filled.row(44)[x], 0.0F) << x;
}

TEST(RemoveSpeckles, KeepsLargeIslandsAndRemovesSmallOnes) {
    cv::Mat disparity(60, 60, CV_32F, cv::Scalar(0.0));
    disparity(cv::Rect(5, 5, 20, 20)).setTo(30.0);  // 400 pixels
    disparity(cv::Rect(40, 40, 5, 5)).setTo(30.0);  // 25
    disparity(cv::Rect(10, 10, 5, 5)).setTo(50.0);  // 25 in the middle of the large one
    remove_speckles(disparity, 100, 1.0F);
    EXPECT_EQ(cv::countNonZero(disparity), 400 - 25);
}

TEST(RemoveUnsupported, KeepsIslandsWithVisibleTextureAndLargeOnes) {
    cv::Mat disparity(200, 200, CV_32F, cv::Scalar(0.0));
    cv::Mat sigma(200, 200, CV_32F, cv::Scalar(0.5));
    disparity(cv::Rect(5, 5, 20, 20)).setTo(30.0);   // 400 pixels, nothing certain
    disparity(cv::Rect(40, 5, 20, 20)).setTo(30.0);  // 400, of them 100 certain
    sigma(cv::Rect(40, 5, 10, 10)).setTo(0.15);
    disparity(cv::Rect(5, 100, 60, 60)).setTo(30.0);  // 3600, nothing certain
    remove_unsupported(disparity, sigma, {}, 1.0F);
    EXPECT_EQ(cv::countNonZero(disparity), 400 + 3600);
    EXPECT_EQ(disparity.at<float>(10, 10), 0.0F);
}

TEST(IslandLimits, GrowWithTheAreaOfLargeImagesAlone) {
    for (const cv::Size usual : {cv::Size(160, 120), cv::Size(640, 480), cv::Size(752, 480)}) {
        EXPECT_EQ(IslandLimits::of(usual).min_pixels, 120);
        EXPECT_EQ(IslandLimits::of(usual).min_support.num_pixels, 2000);
    }
    const IslandLimits large = IslandLimits::of({1920, 1440});  // nine times as large
    EXPECT_EQ(large.min_pixels, 1080);
    EXPECT_EQ(large.min_support.num_pixels, 18'000);
    EXPECT_EQ(large.min_support.num_certain, 40) << "visible texture tells as much at any size";
    EXPECT_EQ(IslandLimits::of({1024, 256}).min_pixels, 120) << "wide, but no larger";
}

TEST(UnconfirmSpeckles, LeavesSmallIslandsAsUnconfirmedWinners) {
    cv::Mat disparity(60, 60, CV_32F, cv::Scalar(0.0));
    disparity(cv::Rect(5, 5, 20, 20)).setTo(30.0);
    disparity(cv::Rect(40, 40, 5, 5)).setTo(20.0);
    unconfirm_speckles(disparity, 100, 1.0F);
    EXPECT_EQ(disparity.at<float>(10, 10), 30.0F);
    EXPECT_EQ(disparity.at<float>(42, 42), -20.0F);
}

TEST(ImageNoise, IsThatOfTheSensorNotOfTheTexture) {
    for (const double noise : {1.5, 3.0, 5.0}) {
        WarpedPairOptions options;
        options.noise = noise;
        options.contrast = 0.3;
        const auto pair = make_warped_pair(slanted, options);
        EXPECT_NEAR(image_noise(pair.left), noise, 0.25 * noise) << noise;
    }
}

// As of a fisheye image with a black surround, or of a dive at night with a lamp too bright.
TEST(ImageNoise, IsThatOfThePixelsThatAreNotClipped) {
    WarpedPairOptions options;
    options.noise = 3.0;
    options.contrast = 0.3;
    for (const int clipped : {0, 2, 255}) {
        cv::Mat image = make_warped_pair(slanted, options).left;
        image.colRange(0, image.cols * 2 / 5).setTo(clipped);
        EXPECT_NEAR(image_noise(image), 3.0, 0.75) << clipped;
    }
    EXPECT_EQ(image_noise(cv::Mat(240, 320, CV_8U, cv::Scalar(0))), 0.5) << "nothing is known";
}

// About two thirds of the disparities must err by less than their stated sigma. The
// formula includes image noise alone, so matches may be slightly better or worse.
TEST(DisparitySigma, TellsTheOrderOfTheRealError) {
    WarpedPairOptions options;
    options.noise = 4.0;
    options.contrast = 0.4;
    const auto pair = make_warped_pair(slanted, options);
    const auto depth = match("sgm", pair.left, pair.right, 64);
    double sum = 0.0;
    int num = 0;
    for (int y = 10; y < 230; ++y)
        for (int x = 70; x < 310; ++x) {
            const float d = depth.disparity_px.at<float>(y, x);
            const double ratio =
                (d - pair.disparity_px.at<float>(y, x)) / depth.sigma_disparity_px.at<float>(y, x);
            if (d <= 0.0F || std::abs(ratio) > 6.0) continue;
            sum += ratio * ratio;
            ++num;
        }
    EXPECT_GT(num, 10000);
    EXPECT_GT(std::sqrt(sum / num), 0.3);
    EXPECT_LT(std::sqrt(sum / num), 2.0);
}

struct MiddleburyPair {
    cv::Mat left, right, disparity_px;
};

MiddleburyPair read_middlebury(const std::string& folder,
                               const std::array<std::string, 3>& files,
                               double scale) {
    const auto path = shared_data("middlebury") / folder;
    MiddleburyPair pair;
    pair.left = cv::imread((path / files[0]).string(), cv::IMREAD_GRAYSCALE);
    pair.right = cv::imread((path / files[1]).string(), cv::IMREAD_GRAYSCALE);
    const cv::Mat truth = cv::imread((path / files[2]).string(), cv::IMREAD_GRAYSCALE);
    if (!truth.empty()) truth.convertTo(pair.disparity_px, CV_32F, 1.0 / scale);
    return pair;
}

// Sets the disparities with the largest sigmas to unknown until `density` of all pixels are known.
void thin_out(types::DepthMap& depth, const cv::Mat& truth_px, double max_px, double density) {
    float low = 0.0F;
    float high = 4.0F;
    const cv::Mat whole = depth.disparity_px.clone();
    for (int i = 0; i < 16; ++i) {
        const float limit = 0.5F * (low + high);
        depth.disparity_px = whole.clone();
        depth.disparity_px.setTo(0.0, depth.sigma_disparity_px > limit);
        const double found = compare_disparity(depth.disparity_px, truth_px, max_px).density;
        (found < density ? low : high) = limit;
    }
}

// Compares with OpenCV's semi-global matcher on photographs with measured ground truth, at the same
// density: those of ours count whose sigma is smallest.
TEST(Middlebury, SgmIsAtLeastAsAccurateAndDenseAsOpenCv) {
    if (!std::filesystem::exists(shared_data("middlebury")))
        GTEST_SKIP()
            << "no Middlebury pairs: set DIVEMESH_SHARED to the folder with the shared data";
    const auto cones = read_middlebury("Cones", {"im2.png", "im6.png", "disp2.png"}, 4.0);
    const auto cloth = read_middlebury("Cloth3", {"view1.png", "view5.png", "disp1.png"}, 2.0);
    for (const auto* pair : {&cones, &cloth}) {
        const int range = pair == &cones ? 64 : 128;
        const auto score = [&](const types::DepthMap& depth) {
            return compare_disparity(depth.disparity_px, pair->disparity_px, range - 1.0);
        };
        types::DepthMap depth = match("sgm", pair->left, pair->right, range);
        const auto all = score(depth);
        const auto opencv = score(match("opencv_sgbm", pair->left, pair->right, range));
        thin_out(depth, pair->disparity_px, range - 1.0, opencv.density);
        const auto own = score(depth);
        EXPECT_LT(own.bad1, opencv.bad1);
        EXPECT_LT(own.median_px, opencv.median_px);
        EXPECT_GT(all.density, opencv.density);
    }
}

}  // namespace
}  // namespace divemesh::stereo
