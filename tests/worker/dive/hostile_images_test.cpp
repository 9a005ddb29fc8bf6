// Images that are made to harm the decoder, or that reveal more than they should.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/image.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

constexpr int kWidth_px = 64;
constexpr int kHeight_px = 48;

cv::Mat gradient() {
    cv::Mat image(kHeight_px, kWidth_px, CV_8UC3);
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
            image.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<unsigned char>(3 * x),
                                                  static_cast<unsigned char>(5 * y),
                                                  static_cast<unsigned char>(x + y));
    return image;
}

std::string jpeg(bool progressive) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", gradient(), bytes, {cv::IMWRITE_JPEG_PROGRESSIVE, progressive ? 1 : 0});
    return {bytes.begin(), bytes.end()};
}

std::string big_endian_16(std::size_t value) {
    return {static_cast<char>(value >> 8), static_cast<char>(value & 255)};
}

// Inserts an APP1 segment right after the beginning of the JPEG.
std::string with_exif(const std::string& jpeg, const std::string& tiff) {
    const std::string content = std::string("Exif\0\0", 6) + tiff;
    return jpeg.substr(0, 2) + "\xff\xe1" + big_endian_16(content.size() + 2) + content +
           jpeg.substr(2);
}

// Returns a big-endian TIFF with one directory of `num_entries` entries that names itself as the
// next directory.
std::string directory_of_itself(std::size_t num_entries, const std::string& entry) {
    std::string tiff("MM\0*\0\0\0\x08", 8);
    tiff += big_endian_16(num_entries);
    tiff += entry;
    return tiff + std::string("\0\0\0\x08", 4);
}

cv::Mat decoded(const std::string& bytes) {
    return decode_image(bytes, read_image_header(bytes), Channels::Bgr);
}

// Returns why the image is refused; "" if it decodes.
std::string refusal(const std::string& bytes) {
    try {
        decoded(bytes);
        return "";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        return error.what();
    }
}

double max_difference(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() ? cv::norm(a, b, cv::NORM_INF) : 256.0;
}

TEST(HostileImagesTest, TenThousandScansAreRefusedBeforeTheyAreDecoded) {
    const std::string good = jpeg(true);
    EXPECT_EQ(refusal(good), "");
    const auto scan = good.rfind("\xff\xda");
    const auto end = good.rfind("\xff\xd9");
    ASSERT_NE(scan, std::string::npos);
    std::string hostile = good.substr(0, end);
    for (int i = 0; i < 10'000; ++i) hostile += good.substr(scan, end - scan);
    EXPECT_NE(refusal(hostile + "\xff\xd9").find("scans"), std::string::npos);
}

TEST(HostileImagesTest, FourColoursAreRefused) {
    std::string cmyk = jpeg(false);
    const auto frame = cmyk.find("\xff\xc0");
    ASSERT_NE(frame, std::string::npos);
    cmyk[frame + 9] = 4;  // components
    EXPECT_NE(refusal(cmyk).find("4 channels"), std::string::npos);
}

TEST(HostileImagesTest, AJpegThatEndsEarlyIsRefused) {
    const std::string good = jpeg(false);
    for (std::size_t size = 0; size < good.size() - 2; size += 7)
        EXPECT_NE(refusal(good.substr(0, size)), "") << size << " of " << good.size();
}

// Random bytes after a valid header either decode to an image of the stated size or are
// refused.
TEST(HostileImagesTest, GarbageBehindAGoodHeaderHurtsNothing) {
    const std::string good = jpeg(false);
    const auto scan = good.find("\xff\xda") + 14;
    std::mt19937 random(1);
    for (int round = 0; round < 200; ++round) {
        std::string bytes = good;
        for (std::size_t i = scan; i + 2 < bytes.size(); ++i)
            bytes[i] = static_cast<char>(random() & 255);
        try {
            EXPECT_EQ(decoded(bytes).size(), cv::Size(kWidth_px, kHeight_px));
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::BadData);
        }
    }
}

TEST(HostileImagesTest, AnExifBombChangesNothing) {
    const std::string good = jpeg(false);
    const std::string turned("\x01\x12\0\x03\0\0\0\x01\0\x06\0\0", 12);      // orientation 6
    const std::string huge("\x87\x69\0\x04\xff\xff\xff\xff\0\0\0\x08", 12);  // states 4 G numbers
    for (const std::string& tiff : {directory_of_itself(1, turned),
                                    directory_of_itself(65'535, turned),
                                    directory_of_itself(65'535, huge),
                                    directory_of_itself(0, ""),
                                    std::string("MM\0*\xff\xff\xff\xff", 8),
                                    std::string()})
        EXPECT_EQ(max_difference(decoded(with_exif(good, tiff)), decoded(good)), 0.0);
}

// The diver's position is in the recording, for people with access to it, but must not be in
// the images that others see.
TEST(HostileImagesTest, TheThumbnailDoesNotContainTheGpsPositionOfAnImage) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    const std::string position = "48.8583701N,2.2944813E";
    for (int i = 0; i < TinyDive::kNumFrames; ++i) {
        cv::Mat image;
        cv::cvtColor(gradient(), image, cv::COLOR_BGR2GRAY);
        std::vector<unsigned char> bytes;
        cv::imencode(".jpg", image, bytes);
        tiny.write("mav0/cam0/data/" + TinyDive::image_name(i),
                   with_exif({bytes.begin(), bytes.end()},
                             directory_of_itself(1,
                                                 std::string("\x88\x25\0\x04\0\0\0\x01", 8) +
                                                     std::string("\0\0\0\x1a", 4)) +
                                 position));
    }
    const auto report = examine_dive(tiny.folder(), folder / "scratch", base::ignore_progress);
    EXPECT_TRUE(report.thumbnail_jpeg.starts_with("\xff\xd8\xff"));
    EXPECT_EQ(report.thumbnail_jpeg.find(position), std::string::npos);
    EXPECT_EQ(report.thumbnail_jpeg.find("Exif"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::dive
