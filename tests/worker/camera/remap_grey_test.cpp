#include "worker/camera/remap_grey.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace divemesh::camera {
namespace {

struct GreyMap {
    cv::Mat pixels;
    cv::Mat parts;
};

// Returns a map that scatters pixels over an image of 61 x 47 and up to 8 pixels beyond it.
GreyMap scattered(cv::Size size) {
    cv::Mat x(size, CV_32F);
    cv::Mat y(size, CV_32F);
    cv::RNG random(7);
    random.fill(x, cv::RNG::UNIFORM, -8.0, 69.0);
    random.fill(y, cv::RNG::UNIFORM, -8.0, 55.0);
    GreyMap map;
    cv::convertMaps(x, y, map.pixels, map.parts, CV_16SC2);
    return map;
}

TEST(RemapGreyTest, GivesTheBytesOfOpenCv) {
    cv::Mat image(47, 61, CV_8UC1);
    cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
    for (const cv::Size size : {cv::Size(233, 91), cv::Size(7, 3), cv::Size(1, 1)}) {
        const GreyMap map = scattered(size);
        cv::Mat expected;
        cv::remap(image, expected, map.pixels, map.parts, cv::INTER_LINEAR);

        const cv::Mat made = remap_grey(image, map.pixels, map.parts);

        ASSERT_EQ(made.size(), size);
        EXPECT_EQ(cv::countNonZero(made != expected), 0);
    }
}

TEST(RemapGreyTest, ReadsAPartOfALargerImageAsAnImage) {
    cv::Mat larger(90, 120, CV_8UC1, cv::Scalar(255));
    cv::Mat image = larger(cv::Rect(20, 30, 61, 47));
    cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, 256);
    const GreyMap map = scattered({200, 40});

    const cv::Mat made = remap_grey(image, map.pixels, map.parts);

    EXPECT_EQ(cv::countNonZero(made != remap_grey(image.clone(), map.pixels, map.parts)), 0);
}

TEST(RemapGreyTest, OfARampItIsThePlaceThatWasRead) {
    cv::Mat ramp(40, 40, CV_8UC1);
    for (int y = 0; y < ramp.rows; ++y)
        for (int x = 0; x < ramp.cols; ++x)
            ramp.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(4 * x + 2 * y);
    const cv::Mat x(1, 1, CV_32F, cv::Scalar(11.25));
    const cv::Mat y(1, 1, CV_32F, cv::Scalar(20.5));
    GreyMap map;
    cv::convertMaps(x, y, map.pixels, map.parts, CV_16SC2);

    EXPECT_EQ(remap_grey(ramp, map.pixels, map.parts).at<std::uint8_t>(0, 0), 86);
}

}  // namespace
}  // namespace divemesh::camera
