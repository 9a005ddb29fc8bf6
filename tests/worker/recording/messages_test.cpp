#include "worker/recording/messages.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "schemas/error.hpp"
#include "tests/worker/recording/message_writer.hpp"
#include "worker/recording/image_file.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kTime_ns = 1'600'000'000'123'456'789;
constexpr Wire kWires[] = {Wire::Ros1, Wire::LittleCdr, Wire::BigCdr};

Serialization serialization_of(Wire wire) {
    return wire == Wire::Ros1 ? Serialization::Ros1 : Serialization::Cdr;
}

// A message byte by byte: of the encapsulation, seconds, nanoseconds, "a", one byte to align to
// eight, 101325.0 and 4.0.
TEST(MessagesTest, APressureInCdrIsReadByteByByte) {
    const std::string bytes(
        "\x00\x01\x00\x00"
        "\x02\x00\x00\x00"
        "\x03\x00\x00\x00"
        "\x02\x00\x00\x00"
        "a\x00\x00\x00"
        "\x00\x00\x00\x00\xd0\xbc\xf8\x40"
        "\x00\x00\x00\x00\x00\x00\x10\x40",
        36);
    const PressureMessage pressure = parse_fluid_pressure(Serialization::Cdr, bytes);
    EXPECT_EQ(pressure.header.timestamp_ns, 2'000'000'003);
    EXPECT_EQ(pressure.header.frame, "a");
    EXPECT_EQ(pressure.pressure_pa, 101325.0);
}

TEST(MessagesTest, AnImuIsReadFromEverySerialization) {
    for (const Wire wire : kWires) {
        const std::string bytes = imu_message(wire, kTime_ns, {0.1, -0.2, 0.3}, {1.5, 9.8, -3.0});
        const ImuMessage imu = parse_imu_message(serialization_of(wire), bytes);
        EXPECT_EQ(imu.header.timestamp_ns, kTime_ns);
        EXPECT_EQ(imu.header.frame, "imu");
        EXPECT_EQ(imu.angular_velocity, (std::array{0.1, -0.2, 0.3}));
        EXPECT_EQ(imu.acceleration, (std::array{1.5, 9.8, -3.0}));
    }
}

TEST(MessagesTest, ACameraInfoIsReadFromEverySerialization) {
    for (const Wire wire : kWires) {
        const std::string bytes = camera_info_message(
            wire,
            640,
            480,
            "plumb_bob",
            {-0.1, 0.03, 0.001, 0.002, 0},
            {std::vector<double>{500, 0, 320, 0, 501, 240, 0, 0, 1},
             std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1},
             std::vector<double>{490, 0, 318, -49, 0, 490, 242, 0, 0, 0, 1, 0}});
        const CameraInfo info = parse_camera_info(serialization_of(wire), bytes);
        EXPECT_EQ(info.width_px, 640U);
        EXPECT_EQ(info.height_px, 480U);
        EXPECT_EQ(info.distortion_model, "plumb_bob");
        EXPECT_EQ(info.distortion_coefficients[3], 0.002);
        EXPECT_EQ(info.camera_matrix[4], 501.0);
        EXPECT_EQ(info.rectification[8], 1.0);
        EXPECT_EQ(info.projection[3], -49.0);
    }
}

TEST(MessagesTest, EveryCutMessageIsAnErrorThatSaysSo) {
    for (const Wire wire : kWires) {
        const std::string whole = image_message(wire, kTime_ns, "mono8", 4, 2, "abcdefgh");
        EXPECT_EQ(parse_image(serialization_of(wire), whole).pixels, "abcdefgh");
        for (std::size_t size = 0; size < whole.size(); ++size) try {
                parse_image(serialization_of(wire), whole.substr(0, size));
                ADD_FAILURE() << size;
            } catch (const Error& error) {
                EXPECT_EQ(error.code(), ErrorCode::BadData);
                EXPECT_NE(std::string(error.what()).find("ends in"), std::string::npos);
            }
    }
}

TEST(MessagesTest, AHostileLengthIsAnErrorBeforeMemoryIsAllocated) {
    MessageWriter message(Wire::LittleCdr);
    message.put_header(1, "cam").put(std::uint32_t{480}).put(std::uint32_t{640}).put_text("x");
    message.put(std::uint32_t{0xffff'ffff});
    EXPECT_THROW(parse_camera_info(Serialization::Cdr, message.bytes()), Error);
    EXPECT_THROW(parse_camera_info(Serialization::Unknown, message.bytes()), Error);
}

cv::Mat image_of(const std::string& encoding, const std::string& pixels, std::uint32_t width_px) {
    const std::string bytes = image_message(Wire::Ros1, 1, encoding, width_px, 2, pixels);
    const ImageFile file = image_file(parse_image(Serialization::Ros1, bytes));
    const std::vector<char> png(file.bytes.begin(), file.bytes.end());
    return cv::imdecode(png, cv::IMREAD_UNCHANGED);
}

TEST(MessagesTest, ImagesKeepTheirPixels) {
    const cv::Mat grey = image_of("mono8", "abcdef", 3);
    EXPECT_EQ(std::string(grey.begin<char>(), grey.end<char>()), "abcdef");
    const cv::Mat deep = image_of("mono16", std::string("\x01\x02\x03\x04\x05\x06\x07\x08", 8), 2);
    EXPECT_EQ(deep.at<std::uint16_t>(1, 1), 0x0807);
    for (const char* encoding : {"rgb8", "rgba8", "bgr8", "bgra8"}) {
        const std::string name = encoding;
        std::string pixel = name.starts_with("rgb") ? "\x10\x20\x30" : "\x30\x20\x10";
        if (name.find('a') != std::string::npos) pixel += '\x7f';
        const cv::Mat color = image_of(name, pixel + pixel + pixel + pixel, 2);
        EXPECT_EQ(color.at<cv::Vec3b>(1, 1), cv::Vec3b(0x30, 0x20, 0x10)) << name;
    }
}

// Under a mosaic of one colour every pixel has that colour, however it is interpolated.
TEST(MessagesTest, ABayerMosaicOfOneColorIsThatColor) {
    for (const std::string mosaic : {"rggb", "bggr", "gbrg", "grbg"}) {
        std::string pixels;
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x) {
                const char filter = mosaic[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
                pixels += filter == 'r' ? '\x60' : filter == 'g' ? '\x40' : '\x20';
            }
        const std::string bytes =
            image_message(Wire::Ros1, 1, "bayer_" + mosaic + "8", 8, 8, pixels);
        const ImageFile file = image_file(parse_image(Serialization::Ros1, bytes));
        const cv::Mat color = cv::imdecode(std::vector<char>(file.bytes.begin(), file.bytes.end()),
                                           cv::IMREAD_UNCHANGED);
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x)
                EXPECT_EQ(color.at<cv::Vec3b>(y, x), cv::Vec3b(0x20, 0x40, 0x60))
                    << mosaic << ' ' << x << ' ' << y;
    }
}

TEST(MessagesTest, AnImageThatContradictsItselfIsRefused) {
    EXPECT_THROW(image_of("mono8", "abcd", 3), Error);  // rows of 2 bytes for 3 pixels
    EXPECT_THROW(image_of("32FC1", "abcd", 2), Error);  // a depth image
    EXPECT_THROW(image_of("mono8", "abcdef", 0xffff'ffff), Error);
    EXPECT_THROW(image_file(CompressedImage{{}, "jpeg", "no image"}), Error);
}

}  // namespace
}  // namespace divemesh::recording
