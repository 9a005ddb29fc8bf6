#include "worker/dive/image_checks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/dive/fixed_pattern.hpp"
#include "worker/dive/image_measures.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumFrames = 20;

// A texture of all sizes seen by a camera that moves by 3 px right and 2 px down a frame.
cv::Mat scene(double frame) {
    static const cv::Mat texture = [] {
        cv::Mat sum = cv::Mat::zeros(600, 800, CV_32F);
        cv::RNG random(3);
        for (int scale = 1; scale <= 32; scale *= 2) {
            cv::Mat noise(600 / scale, 800 / scale, CV_32F);
            random.fill(noise, cv::RNG::NORMAL, 0.0, 10.0);
            cv::resize(noise, noise, sum.size(), 0, 0, cv::INTER_CUBIC);
            sum += noise;
        }
        cv::GaussianBlur(sum, sum, {}, 1.0);
        sum.convertTo(sum, CV_8U, 1.0, 120.0);
        return sum;
    }();
    cv::Mat image;
    const cv::Matx23d shift(1, 0, 20 + 3.0 * frame, 0, 1, 20 + 2.0 * frame);
    cv::warpAffine(texture, image, shift, {640, 480}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    return image;
}

cv::Mat blurred(const cv::Mat& image, double sigma_px) {
    cv::Mat result;
    cv::GaussianBlur(image, result, {}, sigma_px);
    return result;
}

cv::Mat water(int frame) {
    cv::Mat image(480, 640, CV_8UC1);
    cv::RNG random(static_cast<std::uint64_t>(frame));
    random.fill(image, cv::RNG::NORMAL, 100.0, 4.0);
    return image;
}

using Render = std::function<cv::Mat(int frame)>;

std::vector<Finding> findings_of(const Render& left,
                                 const Render& right,
                                 std::optional<double> share = 0.5,
                                 int num_frames = kNumFrames) {
    FindingLog log;
    check_images(
        num_frames,
        [&](int index) {
            LoadedPair pair;
            pair.index = index;
            pair.left.image = left(index);
            pair.right.image = right(index);
            return pair;
        },
        share,
        log);
    return log.all();
}

cv::Mat healthy(int frame) { return scene(frame); }

TEST(ImageChecksTest, HealthyImagesGetNoFinding) {
    EXPECT_TRUE(findings_of(healthy, healthy).empty());
    const Render darker = [](int frame) {
        cv::Mat image;
        scene(frame).convertTo(image, CV_8U, 0.5, 10.0);
        return image;
    };
    EXPECT_TRUE(findings_of(healthy, darker).empty());
}

TEST(ImageChecksTest, AFoggedOrDefocusedCameraIsNamed) {
    const Render defocused = [](int frame) { return blurred(scene(frame), 3.0); };
    const Render fogged = [](int frame) {
        cv::Mat image;
        blurred(scene(frame), 4.0).convertTo(image, CV_8U, 0.4, 130.0);
        return image;
    };

    EXPECT_THAT(findings_of(healthy, defocused),
                HasFinding(Severity::Warning, "camera_unsharp", "cam1"));
    EXPECT_THAT(findings_of(fogged, healthy),
                HasFinding(Severity::Warning, "camera_unsharp", "cam0"));
    EXPECT_THAT(findings_of(healthy, fogged, 0.0),
                HasFinding(Severity::Error, "camera_unsharp", "cam1"));
    EXPECT_THAT(findings_of(healthy, fogged, std::nullopt),
                HasFinding(Severity::Warning, "camera_unsharp", "cam1"));
}

// A camera that is dead still reads noise, which has more fine detail than a scene.
TEST(ImageChecksTest, ADeadCameraDoesNotMakeTheOtherUnsharp) {
    const Render dead = [](int frame) {
        cv::Mat image(480, 640, CV_8UC1);
        cv::RNG random(static_cast<std::uint64_t>(frame));
        random.fill(image, cv::RNG::NORMAL, 1.0, 1.0);
        return image;
    };
    const auto with_dead_left = findings_of(dead, healthy, 0.0);
    EXPECT_THAT(with_dead_left, testing::Not(HasFinding(Severity::Error, "camera_unsharp", "")));
    EXPECT_THAT(with_dead_left, HasFinding(Severity::Error, "images_featureless", "100 %"));
    EXPECT_THAT(findings_of(healthy, dead, 0.0),
                testing::Not(HasFinding(Severity::Error, "camera_unsharp", "")));
    EXPECT_TRUE(is_dark(dead(0)));
    EXPECT_FALSE(is_dark(healthy(0)));
}

TEST(ImageChecksTest, TwoFieldsOfTwoMomentsAreInterlaced) {
    const Render interlaced = [](int frame) {
        cv::Mat image = scene(frame);
        const cv::Mat later = scene(frame + 0.5);
        for (int row = 1; row < image.rows; row += 2) later.row(row).copyTo(image.row(row));
        return image;
    };

    EXPECT_THAT(findings_of(interlaced, interlaced),
                HasFinding(Severity::Warning, "images_interlaced", "cam0"));
}

// Returns the mean of |2 I(y) - I(y - step) - I(y + step)|, by line.
double mean_step_of_lines(const cv::Mat& image, int step) {
    double sum = 0.0;
    int num = 0;
    for (int y = 2; y + 2 < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x, ++num)
            sum += std::abs(2.0 * image.at<unsigned char>(y, x) -
                            image.at<unsigned char>(y - step, x) -
                            image.at<unsigned char>(y + step, x));
    return sum / num;
}

TEST(ImageMeasuresTest, CombingIsTheContrastOfLinesOverThatOfColumns) {
    cv::Mat image = scene(0.0)(cv::Rect(3, 5, 601, 437));  // rows do not follow each other
    for (int row = 1; row < image.rows; row += 2)
        scene(0.5)(cv::Rect(3, 5 + row, 601, 1)).copyTo(image.row(row));
    const cv::Mat columns = image.t();

    const double expected = mean_step_of_lines(image, 1) / mean_step_of_lines(image, 2) /
                            (mean_step_of_lines(columns, 1) / mean_step_of_lines(columns, 2));

    EXPECT_NEAR(combing(image), expected, 1e-12);
}

TEST(ImageMeasuresTest, OfALargeImageTheMiddleTellsCombingAndMosaic) {
    cv::Mat large;
    cv::resize(scene(0.0), large, {1921, 1081}, 0.0, 0.0, cv::INTER_CUBIC);
    const cv::Mat middle = large(cv::Rect((1921 - 640) / 2, (1081 - 640) / 2, 640, 640)).clone();
    EXPECT_EQ(combing(large), combing(middle));
    EXPECT_EQ(mosaic_contrast(large), mosaic_contrast(middle));
    EXPECT_LT(mosaic_contrast(large), 0.005);

    large.row(540) = 0;
    EXPECT_NE(combing(large), combing(middle));
    for (int y = 0; y < large.rows; y += 2)
        for (int x = 0; x < large.cols; x += 2)
            large.at<unsigned char>(y, x) =
                static_cast<unsigned char>(large.at<unsigned char>(y, x) / 2);
    EXPECT_GT(mosaic_contrast(large), 0.1);
}

TEST(ImageMeasuresTest, AReducedImageMeasuresAsTheImageItself) {
    cv::Mat large;
    cv::resize(scene(0.0), large, {1100, 825}, 0.0, 0.0, cv::INTER_CUBIC);
    for (const cv::Mat& image : {large, scene(0.0)}) {
        EXPECT_EQ(sharpness(reduced_to_640_px(image)), sharpness(image));
        EXPECT_EQ(has_texture(reduced_to_640_px(image)), has_texture(image));
        EXPECT_EQ(is_dark(reduced_to_640_px(image)), is_dark(image));
    }
}

TEST(ImageChecksTest, ABayerMosaicOfColouredWaterIsNamedAndHidesNoTexture) {
    const Render mosaic = [](int frame) {
        cv::Mat image = scene(frame);
        for (int y = 0; y < image.rows; ++y)
            for (int x = 0; x < image.cols; ++x)
                if (x % 2 == y % 2)  // red and blue, which green water takes away
                    image.at<unsigned char>(y, x) =
                        static_cast<unsigned char>(image.at<unsigned char>(y, x) * 0.6);
        return image;
    };

    const auto told = findings_of(mosaic, mosaic);

    ASSERT_EQ(told.size(), 1U);
    EXPECT_THAT(told, HasFinding(Severity::Warning, "images_bayer", "differ by 5"));
}

TEST(ImageChecksTest, OpenWaterIsToldAndRefusedIfThereIsNothingElse) {
    const Render half = [](int frame) {
        return frame < kNumFrames / 2 ? scene(frame) : water(frame);
    };

    EXPECT_THAT(findings_of(half, half),
                HasFinding(Severity::Warning, "images_featureless", "50 %"));
    EXPECT_THAT(findings_of(water, water, 0.0),
                HasFinding(Severity::Error, "images_featureless", "100 %"));
    EXPECT_THAT(findings_of(water, water, 0.3),
                HasFinding(Severity::Warning, "images_featureless", "100 %"));
}

TEST(ImageChecksTest, ASceneInAPartOfTheImageHasTexture) {
    const Render fisheye = [](int frame) {
        cv::Mat mask = cv::Mat::zeros(480, 640, CV_8U);
        cv::circle(mask, {320, 240}, 130, cv::Scalar(255), -1);  // a sixth of the image
        cv::Mat image = cv::Mat::zeros(480, 640, CV_8U);
        scene(frame).copyTo(image, mask);
        return image;
    };

    EXPECT_TRUE(findings_of(fisheye, fisheye).empty());
}

TEST(ImageChecksTest, TextThatTheCameraBurnsInIsMasked) {
    FixedPattern pattern;
    FixedPattern without;
    FixedPattern still;
    for (int frame = 0; frame < kNumFrames; ++frame) {
        cv::Mat image = scene(frame);
        without.add(image);
        still.add(scene(0));
        cv::rectangle(image, {0, 0}, {639, 40}, cv::Scalar(0), -1);
        cv::putText(image,
                    "ROV 7  DEPTH 18.2 m  " + std::to_string(frame),
                    {10, 30},
                    cv::FONT_HERSHEY_SIMPLEX,
                    0.8,
                    cv::Scalar(255),
                    2);
        pattern.add(image);
    }

    const cv::Mat mask = pattern.masks().overlay;

    ASSERT_FALSE(mask.empty());
    EXPECT_EQ(mask.at<unsigned char>(22, 100), 255);
    EXPECT_EQ(mask.at<unsigned char>(300, 320), 0);
    EXPECT_TRUE(without.masks().all().empty());
    EXPECT_TRUE(still.masks().all().empty());
}

// In front of a rig at rest, the pattern that stays is the scene, even while fish pass.
TEST(ImageChecksTest, AShoalInFrontOfARigAtRestMakesTheSceneNoPattern) {
    FixedPattern pattern;
    for (int frame = 0; frame < kNumFrames; ++frame) {
        cv::Mat image = scene(0).clone();
        for (int fish = 0; fish < 80; ++fish)
            cv::ellipse(image,
                        {(97 * fish + 60 * frame) % 640, (53 * fish) % 480},
                        {24, 8},
                        0.0,
                        0.0,
                        360.0,
                        cv::Scalar(fish % 2 == 0 ? 230 : 30),
                        -1);
        pattern.add(image);
    }
    EXPECT_TRUE(pattern.masks().all().empty());
}

// Light from waves plays over two thirds of a scene at rest for nineteen twentieths of a recording.
TEST(ImageChecksTest, ALongRestMakesTheSceneNoPattern) {
    constexpr int kNumAtRest = 760;
    constexpr int kNumMoving = 40;
    const Render resting = [](int frame) {
        cv::Mat light = cv::Mat::zeros(480, 640, CV_32F);
        for (int v = 0; v < 320; ++v)
            for (int u = 0; u < light.cols; ++u)
                light.at<float>(v, u) =
                    25.0F * static_cast<float>(std::sin(0.05 * u + 1.7 * frame) *
                                               std::cos(0.06 * v - 0.9 * frame));
        cv::Mat image;
        scene(std::max(0, frame - kNumAtRest)).convertTo(image, CV_32F);
        image += light;
        image.convertTo(image, CV_8U);
        return image;
    };
    constexpr int kNum = kNumAtRest + kNumMoving;

    EXPECT_TRUE(findings_of(resting, resting, 0.5, kNum).empty());
}

// A small part of the image shows the scene; nine tenths are black and never change.
TEST(ImageChecksTest, TheBorderOfAnImageOnBlackIsMaskedAndIsNoOverlay) {
    const cv::Rect shown(240, 160, 200, 150);
    FixedPattern pattern;
    for (int frame = 0; frame < kNumFrames; ++frame) {
        cv::Mat image = cv::Mat::zeros(480, 640, CV_8U);
        scene(frame)(shown).copyTo(image(shown));
        pattern.add(image);
    }

    const FixedPattern::Masks masks = pattern.masks();

    EXPECT_TRUE(masks.overlay.empty());
    ASSERT_FALSE(masks.border.empty());
    cv::Mat scene_part = cv::Mat::zeros(480, 640, CV_8U);
    scene_part(cv::Rect(shown.x + 8, shown.y + 8, shown.width - 16, shown.height - 16)) = 255;
    EXPECT_EQ(cv::countNonZero((masks.border == 255) != (scene_part == 0)), 0);
}

}  // namespace
}  // namespace divemesh::dive
