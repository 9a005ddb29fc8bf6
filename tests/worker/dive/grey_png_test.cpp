#include "worker/dive/grey_png.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tests/synthetic/texture.hpp"

namespace divemesh::dive {
namespace {

std::string png(const cv::Mat& image, std::vector<int> flags = {}) {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", image, bytes, flags);
    return {bytes.begin(), bytes.end()};
}

cv::Mat noise(int width_px, int height_px, int type) {
    cv::Mat image(height_px, width_px, type);
    cv::RNG random(5);
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    return image;
}

TEST(GreyPngTest, GivesWhatOpenCvGives) {
    for (const cv::Mat& image : {synthetic::textured_image(0.0, 0.0), noise(61, 7, CV_8UC1)}) {
        for (const int strategy : {cv::IMWRITE_PNG_STRATEGY_DEFAULT,
                                   cv::IMWRITE_PNG_STRATEGY_FILTERED,
                                   cv::IMWRITE_PNG_STRATEGY_RLE}) {
            const auto decoded = decode_grey_png(png(image, {cv::IMWRITE_PNG_STRATEGY, strategy}));
            ASSERT_TRUE(decoded);
            EXPECT_EQ(cv::norm(*decoded, image, cv::NORM_INF), 0.0);
        }
    }
}

TEST(GreyPngTest, LeavesOtherKindsToOpenCv) {
    EXPECT_FALSE(decode_grey_png(png(noise(8, 8, CV_8UC3))));
    EXPECT_FALSE(decode_grey_png(png(noise(8, 8, CV_16UC1))));
    EXPECT_FALSE(decode_grey_png("\xff\xd8\xff"));
    EXPECT_FALSE(decode_grey_png(""));
}

TEST(GreyPngTest, RefusesEveryDamage) {
    const std::string whole = png(noise(24, 16, CV_8UC1));
    ASSERT_TRUE(decode_grey_png(whole));
    for (std::size_t size = 0; size < whole.size(); size += 5)
        EXPECT_FALSE(decode_grey_png(whole.substr(0, size))) << size;
    for (std::size_t at = 0; at < whole.size(); ++at) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x40);
        EXPECT_FALSE(decode_grey_png(damaged)) << at;
    }
}

}  // namespace
}  // namespace divemesh::dive
