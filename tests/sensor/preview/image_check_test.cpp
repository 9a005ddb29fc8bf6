#include "sensor/preview/image_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/paths.hpp"

namespace divemesh::sensor {
namespace {

// Every `step`-th image of a recording, grey.
std::vector<cv::Mat> images_of(const std::string& dive, std::size_t step) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry :
         std::filesystem::directory_iterator(shared_data(dive) / "mav0" / "cam0" / "data"))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<cv::Mat> images;
    for (std::size_t i = 0; i < files.size(); i += step)
        images.push_back(cv::imread(files[i].string(), cv::IMREAD_GRAYSCALE));
    return images;
}

cv::Mat darkened(const cv::Mat& image) {  // an eighth of the light, and the lens half covered
    cv::Mat dark;
    image.convertTo(dark, CV_8U, 0.08);
    return dark;
}

cv::Mat blurred(const cv::Mat& image, double sigma_px) {
    cv::Mat blurred;
    cv::GaussianBlur(image, blurred, {}, sigma_px);
    return blurred;
}

cv::Mat less_contrast(const cv::Mat& image) {
    cv::Mat flat;
    image.convertTo(flat, CV_8U, 0.5, 64.0);
    return flat;
}

template <typename Change, typename Is>
double share(const std::vector<cv::Mat>& images, const Change& change, const Is& is) {
    const auto count = std::count_if(images.begin(), images.end(), [&](const cv::Mat& image) {
        return is(measure_image(change(image)));
    });
    return static_cast<double>(count) / static_cast<double>(images.size());
}

bool is_dark(const ImageQuality& quality) { return quality.is_dark; }
bool is_blurred(const ImageQuality& quality) { return quality.is_blurred; }
cv::Mat as_it_is(const cv::Mat& image) { return image; }

class ImageCheckOfDiveTest : public testing::TestWithParam<std::string> {
protected:
    void SetUp() override {
        if (!std::filesystem::exists(shared_data(GetParam())))
            GTEST_SKIP() << shared_data(GetParam()) << " is not there: nothing to measure";
        images_ = images_of(GetParam(), 10);
    }
    std::vector<cv::Mat> images_;
};

TEST_P(ImageCheckOfDiveTest, TellsDarkImagesFromGoodOnes) {
    EXPECT_LE(share(images_, as_it_is, is_dark), 0.05);
    EXPECT_GE(share(images_, darkened, is_dark), 0.95);
}

TEST_P(ImageCheckOfDiveTest, TellsBlurredImagesFromSharpOnes) {
    std::vector<double> sharp, soft;
    for (const cv::Mat& image : images_) {
        sharp.push_back(measure_image(image).sharpness.value_or(9.0));
        soft.push_back(measure_image(blurred(image, 3.0)).sharpness.value_or(0.0));
    }
    std::sort(sharp.begin(), sharp.end());
    std::sort(soft.begin(), soft.end());
    std::cout << GetParam() << ": sharp " << sharp.front() << " to " << sharp.back()
              << ", blurred by 3 px " << soft.front() << " to " << soft.back() << '\n';
    EXPECT_LE(share(images_, as_it_is, is_blurred), 0.05);
    EXPECT_GE(share(
                  images_, [](const auto& p) { return blurred(p, 3.0); }, is_blurred),
              0.95);
}

TEST_P(ImageCheckOfDiveTest, DoesNotTakeHazeForBlur) {
    EXPECT_LE(share(images_, less_contrast, is_blurred), 0.05);
    EXPECT_GE(
        share(
            images_, [](const auto& p) { return less_contrast(blurred(p, 3.0)); }, is_blurred),
        0.9);
}

TEST_P(ImageCheckOfDiveTest, TellsRepeatedImagesFromNewOnes) {
    ImageCheck moving;
    ImageCheck frozen;
    for (std::size_t i = 0; i < std::min<std::size_t>(images_.size(), 20); ++i) {
        moving.check(images_[i], static_cast<std::int64_t>(i));
        frozen.check(images_[0], static_cast<std::int64_t>(i));
    }
    EXPECT_EQ(moving.shares()->frozen, 0.0);
    EXPECT_GE(frozen.shares()->frozen, 0.9);
}

INSTANTIATE_TEST_SUITE_P(Dives,
                         ImageCheckOfDiveTest,
                         testing::Values("tank", "barge", "euroc_mh01"));

TEST(ImageCheckTest, SaysNothingOfFocusWhereThereIsNothingToSee) {
    cv::Mat water(480, 640, CV_8U);
    cv::randn(water, 90, 2);
    cv::GaussianBlur(water, water, {}, 1.0);
    const ImageQuality quality = measure_image(water);
    EXPECT_FALSE(quality.sharpness);
    EXPECT_FALSE(quality.is_blurred);
}

TEST(ImageCheckTest, CountsAFrameOnce) {
    ImageCheck check;
    const cv::Mat image(480, 640, CV_8U, cv::Scalar(90));
    check.check(image, 7);
    check.check(image, 7);
    EXPECT_EQ(check.shares()->frozen, 0.0);
}

}  // namespace
}  // namespace divemesh::sensor
