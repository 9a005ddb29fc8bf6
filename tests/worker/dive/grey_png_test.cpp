#include "worker/dive/grey_png.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tests/synthetic/texture.hpp"
#include "worker/dive/image.hpp"

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
    for (const cv::Mat& image :
         {synthetic::textured_image(0.0, 0.0), noise(61, 7, CV_8UC1), noise(1, 40, CV_8UC1)}) {
        for (const int strategy : {cv::IMWRITE_PNG_STRATEGY_DEFAULT,
                                   cv::IMWRITE_PNG_STRATEGY_FILTERED,
                                   cv::IMWRITE_PNG_STRATEGY_RLE}) {
            const auto decoded = decode_grey_png(png(image, {cv::IMWRITE_PNG_STRATEGY, strategy}));
            ASSERT_TRUE(decoded);
            EXPECT_EQ(cv::norm(*decoded, image, cv::NORM_INF), 0.0);
        }
    }
}

TEST(DecodeImageTest, AGreyPngInColourIsWhatOpenCvGives) {
    const std::string bytes = png(noise(61, 7, CV_8UC1));
    const cv::Mat expected = cv::imdecode(
        cv::Mat(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data())),
        cv::IMREAD_COLOR);
    const cv::Mat decoded = decode_image(bytes, read_image_header(bytes), Channels::Bgr);
    ASSERT_EQ(decoded.type(), CV_8UC3);
    EXPECT_EQ(cv::norm(decoded, expected, cv::NORM_INF), 0.0);
}

TEST(DecodeImageTest, AReducedImageIsTheMeanOfItsPixels) {
    cv::Mat smooth;
    cv::GaussianBlur(noise(203, 101, CV_8UC3), smooth, {}, 6.0);
    cv::normalize(smooth, smooth, 0, 255, cv::NORM_MINMAX);
    for (const char* format : {".png", ".jpg"}) {
        std::vector<unsigned char> encoded;
        cv::imencode(format, smooth, encoded, {cv::IMWRITE_JPEG_QUALITY, 100});
        const std::string bytes(encoded.begin(), encoded.end());
        for (const int reduction : {2, 4, 8}) {
            const cv::Size size(203 / reduction, 101 / reduction);
            const cv::Rect squares(0, 0, size.width * reduction, size.height * reduction);
            cv::Mat expected;
            cv::resize(smooth(squares), expected, size, 0.0, 0.0, cv::INTER_AREA);
            const cv::Mat decoded =
                decode_image(bytes, read_image_header(bytes), Channels::Bgr, reduction);
            ASSERT_EQ(decoded.size(), size) << format << " / " << reduction;
            EXPECT_LT(cv::norm(decoded, expected, cv::NORM_L1) / (3.0 * size.area()), 3.0)
                << format << " / " << reduction;
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
