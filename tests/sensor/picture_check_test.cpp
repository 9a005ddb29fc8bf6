#include "sensor/picture_check.hpp"

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

// Every `step`-th picture of a recording, grey.
std::vector<cv::Mat> pictures_of(const std::string& dive, std::size_t step) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry :
         std::filesystem::directory_iterator(shared_data(dive) / "mav0" / "cam0" / "data"))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<cv::Mat> pictures;
    for (std::size_t i = 0; i < files.size(); i += step)
        pictures.push_back(cv::imread(files[i].string(), cv::IMREAD_GRAYSCALE));
    return pictures;
}

cv::Mat darkened(const cv::Mat& picture) {  // an eighth of the light, and the lens half covered
    cv::Mat dark;
    picture.convertTo(dark, CV_8U, 0.08);
    return dark;
}

cv::Mat blurred(const cv::Mat& picture, double sigma_px) {
    cv::Mat blurred;
    cv::GaussianBlur(picture, blurred, {}, sigma_px);
    return blurred;
}

cv::Mat less_contrast(const cv::Mat& picture) {
    cv::Mat flat;
    picture.convertTo(flat, CV_8U, 0.5, 64.0);
    return flat;
}

template <typename Change, typename Is>
double share(const std::vector<cv::Mat>& pictures, const Change& change, const Is& is) {
    const auto count = std::count_if(pictures.begin(), pictures.end(), [&](const cv::Mat& picture) {
        return is(measure_picture(change(picture)));
    });
    return static_cast<double>(count) / static_cast<double>(pictures.size());
}

bool is_dark(const PictureQuality& quality) { return quality.is_dark; }
bool is_blurred(const PictureQuality& quality) { return quality.is_blurred; }
cv::Mat as_it_is(const cv::Mat& picture) { return picture; }

class PictureCheckOfDiveTest : public testing::TestWithParam<std::string> {
protected:
    void SetUp() override {
        if (!std::filesystem::exists(shared_data(GetParam())))
            GTEST_SKIP() << shared_data(GetParam()) << " is not there: nothing to measure";
        pictures_ = pictures_of(GetParam(), 10);
    }
    std::vector<cv::Mat> pictures_;
};

TEST_P(PictureCheckOfDiveTest, TellsDarkPicturesFromGoodOnes) {
    EXPECT_LE(share(pictures_, as_it_is, is_dark), 0.05);
    EXPECT_GE(share(pictures_, darkened, is_dark), 0.95);
}

TEST_P(PictureCheckOfDiveTest, TellsBlurredPicturesFromSharpOnes) {
    std::vector<double> sharp, soft;
    for (const cv::Mat& picture : pictures_) {
        sharp.push_back(measure_picture(picture).sharpness.value_or(9.0));
        soft.push_back(measure_picture(blurred(picture, 3.0)).sharpness.value_or(0.0));
    }
    std::sort(sharp.begin(), sharp.end());
    std::sort(soft.begin(), soft.end());
    std::cout << GetParam() << ": sharp " << sharp.front() << " to " << sharp.back()
              << ", blurred by 3 px " << soft.front() << " to " << soft.back() << '\n';
    EXPECT_LE(share(pictures_, as_it_is, is_blurred), 0.05);
    EXPECT_GE(share(
                  pictures_, [](const auto& p) { return blurred(p, 3.0); }, is_blurred),
              0.95);
}

TEST_P(PictureCheckOfDiveTest, DoesNotTakeHazeForBlur) {
    EXPECT_LE(share(pictures_, less_contrast, is_blurred), 0.05);
    EXPECT_GE(
        share(
            pictures_, [](const auto& p) { return less_contrast(blurred(p, 3.0)); }, is_blurred),
        0.9);
}

TEST_P(PictureCheckOfDiveTest, TellsRepeatedPicturesFromNewOnes) {
    PictureCheck moving;
    PictureCheck frozen;
    for (std::size_t i = 0; i < std::min<std::size_t>(pictures_.size(), 20); ++i) {
        moving.look(pictures_[i], static_cast<std::int64_t>(i));
        frozen.look(pictures_[0], static_cast<std::int64_t>(i));
    }
    EXPECT_EQ(moving.shares()->frozen, 0.0);
    EXPECT_GE(frozen.shares()->frozen, 0.9);
}

INSTANTIATE_TEST_SUITE_P(Dives,
                         PictureCheckOfDiveTest,
                         testing::Values("tank", "barge", "euroc_mh01"));

TEST(PictureCheckTest, SaysNothingOfFocusWhereThereIsNothingToSee) {
    cv::Mat water(480, 640, CV_8U);
    cv::randn(water, 90, 2);
    cv::GaussianBlur(water, water, {}, 1.0);
    const PictureQuality quality = measure_picture(water);
    EXPECT_FALSE(quality.sharpness);
    EXPECT_FALSE(quality.is_blurred);
}

TEST(PictureCheckTest, CountsAFrameOnce) {
    PictureCheck check;
    const cv::Mat picture(480, 640, CV_8U, cv::Scalar(90));
    check.look(picture, 7);
    check.look(picture, 7);
    EXPECT_EQ(check.shares()->frozen, 0.0);
}

}  // namespace
}  // namespace divemesh::sensor
