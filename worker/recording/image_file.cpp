#include "worker/recording/image_file.hpp"

#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/recording/fast_png.hpp"

namespace divemesh::recording {
namespace {

constexpr int kAsItIs = -1;  // no conversion

// An encoding of sensor_msgs/image_encodings, and the conversion to what OpenCV writes as PNG.
struct Encoding {
    std::string_view name;
    int type = CV_8UC1;
    int conversion = kAsItIs;
};
constexpr Encoding kEncodings[] = {
    {"mono8", CV_8UC1, kAsItIs},
    {"8UC1", CV_8UC1, kAsItIs},
    {"mono16", CV_16UC1, kAsItIs},
    {"16UC1", CV_16UC1, kAsItIs},
    {"bgr8", CV_8UC3, kAsItIs},
    {"8UC3", CV_8UC3, kAsItIs},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgr16", CV_16UC3, kAsItIs},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"bgra16", CV_16UC4, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
    // OpenCV names a mosaic by the second and third pixel of its second row.
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2BGR},
};

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

const Encoding& encoding_of(const RawImage& image) {
    for (const Encoding& encoding : kEncodings)
        if (encoding.name == image.encoding) return encoding;
    fail("the encoding '" + dive::printable(image.encoding) +
         "' is not read: record mono8, mono16, rgb8, bgr8, rgba8, bgra8 or a Bayer mosaic");
}

// Returns a copy of the pixels, in this machine's byte order.
cv::Mat copied(const RawImage& image, int type) {
    const std::uint64_t num_pixels = std::uint64_t{image.width_px} * image.height_px;
    const std::uint64_t used_bytes = std::uint64_t{image.width_px} * CV_ELEM_SIZE(type);
    if (num_pixels == 0 ||
        num_pixels > static_cast<std::uint64_t>(dive::DiveLimits{}.max_image_pixels))
        fail("it states " + std::to_string(image.width_px) + " x " +
             std::to_string(image.height_px) + " px");
    if (image.row_bytes < used_bytes ||
        image.pixels.size() < std::uint64_t{image.row_bytes} * image.height_px)
        fail("its " + std::to_string(image.pixels.size()) + " bytes are too few for " +
             std::to_string(image.height_px) + " rows of " + std::to_string(image.row_bytes));
    const cv::Mat rows(static_cast<int>(image.height_px),
                       static_cast<int>(image.width_px),
                       type,
                       const_cast<char*>(image.pixels.data()),
                       image.row_bytes);
    cv::Mat pixels = rows.clone();
    if (CV_MAT_DEPTH(type) == CV_16U && image.is_big_endian)
        pixels.forEach<std::uint16_t>([](std::uint16_t& value, const int*) {
            value = static_cast<std::uint16_t>(value << 8 | value >> 8);
        });
    return pixels;
}

cv::Mat converted(cv::Mat pixels, int conversion) {
    if (conversion == kAsItIs) return pixels;
    try {
        cv::cvtColor(pixels, pixels, conversion);
    } catch (const cv::Exception&) {  // a mosaic of one pixel
        fail("its pixels cannot be converted to colours");
    }
    return pixels;
}

}  // namespace

ImageFile image_file(const RawImage& image) {
    const Encoding& encoding = encoding_of(image);
    ImageFile file;
    file.bytes = fast_png(converted(copied(image, encoding.type), encoding.conversion));
    file.header = dive::read_image_header(file.bytes);
    return file;
}

ImageFile image_file(const CompressedImage& image) {
    return {std::string(image.file), dive::read_image_header(image.file)};
}

}  // namespace divemesh::recording
