// Compares the walk over the markers with files of a real encoder.
#include "schemas/jpeg_header.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "schemas/error.hpp"

namespace divemesh {
namespace {

std::string encoded(int width, int height, int type, const std::vector<int>& options = {}) {
    cv::Mat image(height, width, type);
    cv::randu(image, 0, 255);
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", image, bytes, options);
    return {bytes.begin(), bytes.end()};
}

TEST(JpegHeaderTest, KnowsTheSizeOfWhatAnEncoderWrites) {
    for (const auto& [width, height] : {std::pair(1, 1), {640, 480}, {17, 4000}})
        for (const int type : {CV_8UC1, CV_8UC3})
            for (const int progressive : {0, 1}) {
                const std::string bytes = encoded(width,
                                                  height,
                                                  type,
                                                  {cv::IMWRITE_JPEG_PROGRESSIVE,
                                                   progressive,
                                                   cv::IMWRITE_JPEG_RST_INTERVAL,
                                                   progressive});
                const JpegSize size = read_jpeg_size(bytes);
                EXPECT_EQ(size.width, width);
                EXPECT_EQ(size.height, height);
            }
}

TEST(JpegHeaderTest, RefusesEveryPieceOfAWholeOne) {
    const std::string whole = encoded(64, 48, CV_8UC3);
    for (std::size_t length = 0; length < whole.size(); ++length)
        EXPECT_THROW(read_jpeg_size(std::string_view(whole).substr(0, length)), Error) << length;
    EXPECT_THROW(read_jpeg_size("\x89PNG\r\n\x1A\n"), Error);
    EXPECT_THROW(read_jpeg_size(std::string(1000, '\xFF')), Error);
    EXPECT_THROW(read_jpeg_size(whole + "x"), Error);
}

}  // namespace
}  // namespace divemesh
