#include "worker/io/jpeg.hpp"

#include <opencv2/imgcodecs.hpp>

#include "schemas/error.hpp"

namespace divemesh::io {
namespace {

// Returns whether a marker begins a frame: SOF0 to SOF15 without DHT, JPG and DAC.
bool begins_frame(unsigned marker) {
    return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

}  // namespace

std::string encode_jpeg(const cv::Mat& image, int quality) {
    std::vector<std::uint8_t> bytes;
    if (!cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality}))
        throw Error(ErrorCode::Unavailable,
                    "cannot encode an image of " + std::to_string(image.cols) + " x " +
                        std::to_string(image.rows) + " px as JPEG: free memory");
    return {bytes.begin(), bytes.end()};
}

std::optional<cv::Size> jpeg_size(std::string_view jpeg) {
    constexpr std::size_t kFrameHeader_bytes = 9;  // marker, length, precision, height, width
    const auto byte = [&](std::size_t i) { return unsigned{static_cast<std::uint8_t>(jpeg[i])}; };
    const auto word = [&](std::size_t i) { return static_cast<int>(byte(i) << 8U | byte(i + 1)); };
    if (!jpeg.starts_with("\xff\xd8")) return std::nullopt;
    std::size_t at = 2;
    while (at + kFrameHeader_bytes <= jpeg.size() && byte(at) == 0xff) {
        if (begins_frame(byte(at + 1))) return cv::Size(word(at + 7), word(at + 5));
        at += 2 + static_cast<std::size_t>(word(at + 2));
    }
    return std::nullopt;
}

cv::Mat decode_jpeg(std::string_view jpeg) {
    const std::vector<std::uint8_t> bytes(jpeg.begin(), jpeg.end());
    if (bytes.empty()) return {};
    return cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
}

}  // namespace divemesh::io
