#include "worker/recording/stored_image.hpp"

#include <bit>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "schemas/error.hpp"
#include "worker/dive/dive.hpp"
#include "worker/recording/raster_header.hpp"

namespace divemesh::recording {
namespace {

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

bool is_stored_as_it_is(std::string_view bytes) {
    return bytes.starts_with("\x89PNG\r\n\x1a\n") || bytes.starts_with("\xff\xd8\xff");
}

void check_size(std::int64_t width_px, std::int64_t height_px) {
    if (width_px > dive::DiveLimits{}.max_image_pixels / height_px)
        fail("its header states " + std::to_string(width_px) + " x " + std::to_string(height_px) +
             " px, more than the 64 million allowed");
}

cv::Mat decoded(const std::string& bytes) {
    const cv::Mat buffer(
        1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    cv::Mat pixels;
    try {
        pixels = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
        pixels.release();
    }
    if (pixels.empty()) fail("its data is damaged or incomplete");
    return pixels;
}

// Returns how many bits the values of an image have, of 8 or 16.
int bits_used(const cv::Mat& pixels, std::int64_t max_value, const PixelOptions& options) {
    const int all = static_cast<int>(8 * pixels.elemSize1());
    if (options.num_bits > 0 && all == 16) return options.num_bits;
    if (max_value == 0) return all;
    return static_cast<int>(std::bit_width(static_cast<std::uint64_t>(max_value)));
}

// Moves values up so that they fill their 8 or 16 bits.
void fill_bits(cv::Mat& pixels, int num_bits) {
    const int all = static_cast<int>(8 * pixels.elemSize1());
    if (num_bits >= all) return;
    double largest = 0.0;
    cv::minMaxLoc(pixels.reshape(1), nullptr, &largest);
    if (largest >= static_cast<double>(1 << num_bits))
        fail("it has the value " + std::to_string(static_cast<int>(largest)) + ", more than " +
             std::to_string(num_bits) + " bits hold: state them by --bits");
    pixels.convertTo(pixels, -1, static_cast<double>(1 << (all - num_bits)));
}

std::string encoding_of(const cv::Mat& pixels, const std::string& bayer) {
    const bool is_long = pixels.depth() == CV_16U;
    if (pixels.depth() != CV_8U && !is_long) fail("its values are neither of 8 nor of 16 bits");
    const char* const bits = is_long ? "16" : "8";
    if (!bayer.empty()) {
        if (pixels.channels() != 1) fail("it has colours, so it is no Bayer mosaic");
        return "bayer_" + bayer + bits;
    }
    switch (pixels.channels()) {
        case 1: return std::string("mono") + bits;
        case 3: return std::string("bgr") + bits;
        case 4: return std::string("bgra") + bits;
        default: fail("it has " + std::to_string(pixels.channels()) + " channels");
    }
}

ImageFile converted(cv::Mat pixels, int num_bits, const std::string& bayer) {
    const std::string encoding = encoding_of(pixels, bayer);
    fill_bits(pixels, num_bits);
    RawImage raw;
    raw.width_px = static_cast<std::uint32_t>(pixels.cols);
    raw.height_px = static_cast<std::uint32_t>(pixels.rows);
    raw.encoding = encoding;
    raw.row_bytes = static_cast<std::uint32_t>(pixels.step);
    raw.pixels = {reinterpret_cast<const char*>(pixels.data), pixels.step * raw.height_px};
    return image_file(raw);
}

}  // namespace

ImageFile stored_image(std::string bytes, const PixelOptions& options) {
    if (!is_stored_as_it_is(bytes)) {
        const RasterHeader header = read_raster_header(bytes);
        check_size(header.width_px, header.height_px);
        cv::Mat pixels = decoded(bytes);
        const int num_bits = bits_used(pixels, header.max_value, options);
        return converted(std::move(pixels), num_bits, options.bayer);
    }
    const dive::ImageHeader header = dive::read_image_header(bytes);
    check_size(header.width_px, header.height_px);
    if (options.bayer.empty() && options.num_bits == 0) return {std::move(bytes), header};
    cv::Mat pixels = decoded(bytes);
    const int num_bits = bits_used(pixels, 0, options);
    return converted(std::move(pixels), num_bits, options.bayer);
}

}  // namespace divemesh::recording
