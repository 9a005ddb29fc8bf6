#include "worker/dive/repeated_images.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace divemesh::dive {
namespace {

using Kind = RepeatedImages::Kind;

// A textured scene that passes a camera.
class Passage {
public:
    Passage() {
        cv::Mat noise(300, 1200, CV_8UC1);
        cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 255);
        cv::GaussianBlur(noise, scene_, {}, 5.0);
        cv::normalize(scene_, scene_, 20, 235, cv::NORM_MINMAX);
    }

    // The image after `moved_px`, with the noise of a sensor.
    cv::Mat at(int moved_px, double noise_grey = 1.0) {
        cv::Mat values;
        scene_(cv::Rect(moved_px, 20, 320, 240)).convertTo(values, CV_32F);
        cv::Mat noise(values.size(), CV_32F);
        random_.fill(noise, cv::RNG::NORMAL, 0.0, noise_grey);
        cv::Mat image;
        cv::Mat(values + noise).convertTo(image, CV_8U);
        return image;
    }

private:
    cv::Mat scene_;
    cv::RNG random_{11};
};

cv::Mat encoded_again(const cv::Mat& image, int quality) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
    return cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
}

std::vector<Kind> kinds_of(const std::vector<cv::Mat>& images) {
    RepeatedImages repeated;
    repeated.learn({images.begin(), images.begin() + 8});
    std::vector<Kind> kinds;
    for (const cv::Mat& image : images) kinds.push_back(repeated.add(image));
    return kinds;
}

class ReencodedTest : public testing::TestWithParam<int> {};

TEST_P(ReencodedTest, AVideoOfThreeTimesTheRateShowsWhichImagesAreNew) {
    Passage passage;
    std::vector<cv::Mat> images;
    for (int i = 0; i < 20; ++i) {
        images.push_back(encoded_again(passage.at(12 * i), 95));
        for (int copy = 0; copy < 2; ++copy)
            images.push_back(encoded_again(images.back(), GetParam() - copy));
    }
    const std::vector<Kind> kinds = kinds_of(images);
    for (std::size_t i = 0; i < kinds.size(); ++i)
        EXPECT_EQ(kinds[i], i % 3 == 0 ? Kind::No : Kind::Reencoded) << i;
}

INSTANTIATE_TEST_SUITE_P(Qualities, ReencodedTest, testing::Values(98, 95));

TEST(RepeatedImagesTest, SlowMotionIsNotRepetition) {
    Passage passage;
    std::vector<cv::Mat> images;
    for (int i = 0; i < 30; ++i) images.push_back(passage.at(10 * i));
    for (int i = 0; i < 60; ++i) images.push_back(passage.at(300 + i));
    EXPECT_EQ(kinds_of(images), std::vector<Kind>(images.size(), Kind::No));
}

TEST(RepeatedImagesTest, ARestLosesNoImageWithNoiseAndThreeAtMostWithout) {
    Passage passage;
    std::vector<cv::Mat> images;
    for (int i = 0; i < 20; ++i) images.push_back(passage.at(12 * i));
    std::vector<cv::Mat> without_noise = images;
    for (int i = 0; i < 40; ++i) {
        images.push_back(passage.at(12 * 19, 1.5));
        without_noise.push_back(passage.at(12 * 19, 0.1));
    }
    EXPECT_EQ(kinds_of(images), std::vector<Kind>(images.size(), Kind::No));
    const std::vector<Kind> kinds = kinds_of(without_noise);
    EXPECT_EQ(std::ranges::count(kinds.begin(), kinds.begin() + 20, Kind::No), 20);
    EXPECT_LE(std::ranges::count(kinds.begin() + 20, kinds.end(), Kind::Reencoded), 3);
}

TEST(RepeatedImagesTest, AnExactCopyIsOneHoweverOftenButNotOfWater) {
    Passage passage;
    const cv::Mat image = passage.at(0);
    EXPECT_EQ(kinds_of(std::vector<cv::Mat>(8, image)),
              (std::vector<Kind>{Kind::No,
                                 Kind::Exact,
                                 Kind::Exact,
                                 Kind::Exact,
                                 Kind::Exact,
                                 Kind::Exact,
                                 Kind::Exact,
                                 Kind::Exact}));
    const cv::Mat water(240, 320, CV_8UC1, cv::Scalar(90));
    EXPECT_EQ(kinds_of(std::vector<cv::Mat>(8, water)), std::vector<Kind>(8, Kind::No));
}

}  // namespace
}  // namespace divemesh::dive
