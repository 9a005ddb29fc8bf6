#include "worker/dive/image.hpp"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/dive/big_endian.hpp"
#include "worker/dive/grey_png.hpp"

namespace divemesh::dive {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
constexpr int kMaxJpegScans = 64;  // a progressive image has about ten

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

// The signatures of formats that people record in, each at an offset.
struct ForeignFormat {
    std::string_view name;
    std::size_t offset;
    std::string_view signature;
};
constexpr ForeignFormat kForeignFormats[] = {
    {"BMP", 0, "BM"},
    {"TIFF or camera raw", 0, std::string_view("II*\0", 4)},
    {"TIFF or camera raw", 0, std::string_view("MM\0*", 4)},
    {"WebP", 8, "WEBP"},
    {"HEIF or AVIF", 4, "ftyp"},
    {"PNM", 0, "P5"},
    {"PNM", 0, "P6"},
};

[[noreturn]] void fail_as_foreign(std::string_view bytes) {
    for (const ForeignFormat& format : kForeignFormats)
        if (bytes.size() >= format.offset &&
            bytes.substr(format.offset).starts_with(format.signature))
            fail(
                "it is " + std::string(format.name) +
                ", and only PNG and JPEG are read: convert the images to PNG (divemesh import does "
                "it for TIFF, BMP, PGM and PPM)");
    fail("it is neither PNG nor JPEG");
}

// Reads the signature, then IHDR: length, type, width, height, depth, colour type (PNG
// specification, 11.2).
ImageHeader read_png_header(std::string_view bytes) {
    if (bytes.size() < 33 || bytes.substr(12, 4) != "IHDR") fail("the PNG ends in its header");
    ImageHeader header;
    header.format = ImageFormat::Png;
    header.width_px = big_endian(bytes, 16, 4);
    header.height_px = big_endian(bytes, 20, 4);
    header.bits_per_channel = static_cast<unsigned char>(bytes[24]);
    const int color_type = static_cast<unsigned char>(bytes[25]);
    header.num_channels = color_type == 0 || color_type == 4 ? 1 : 3;
    return header;
}

// Returns whether a marker is a frame header of a baseline, extended or progressive image (ITU
// T.81, B.2.2).
bool is_frame_marker(int marker) { return marker >= 0xc0 && marker <= 0xc2; }
bool is_unknown_frame_marker(int marker) {
    return marker >= 0xc3 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

int num_jpeg_scans(std::string_view bytes) {
    int count = 0;
    for (std::size_t at = bytes.find("\xff\xda"); at != std::string_view::npos;
         at = bytes.find("\xff\xda", at + 2))
        ++count;
    return count;
}

void check_jpeg_scans(std::string_view bytes, std::size_t first_scan) {
    if (bytes.find("\xff\xd9", first_scan) == std::string_view::npos)
        fail("the JPEG ends early: it was cut short");
    if (num_jpeg_scans(bytes) > kMaxJpegScans) fail("the JPEG has an absurd number of scans");
}

ImageHeader read_jpeg_header(std::string_view bytes) {
    ImageHeader header;
    header.format = ImageFormat::Jpeg;
    for (std::size_t at = 2; at + 4 <= bytes.size();) {
        if (static_cast<unsigned char>(bytes[at]) != 0xff) fail("the JPEG's markers are damaged");
        const int marker = static_cast<unsigned char>(bytes[at + 1]);
        if (marker == 0xff) {  // fill byte
            ++at;
            continue;
        }
        const auto length = static_cast<std::size_t>(big_endian(bytes, at + 2, 2));
        if (length < 2 || at + 2 + length > bytes.size()) fail("the JPEG ends in its header");
        if (is_unknown_frame_marker(marker)) fail("this kind of JPEG is not supported");
        if (is_frame_marker(marker)) {
            if (length < 8) fail("the JPEG's frame header is too short");
            header.bits_per_channel = static_cast<unsigned char>(bytes[at + 4]);
            header.height_px = big_endian(bytes, at + 5, 2);
            header.width_px = big_endian(bytes, at + 7, 2);
            header.num_channels = static_cast<unsigned char>(bytes[at + 9]);
        }
        if (marker == 0xda) {
            if (header.num_channels == 0) fail("the JPEG has no frame header");
            check_jpeg_scans(bytes, at);
            return header;
        }
        at += 2 + length;
    }
    fail("the JPEG ends in its header");
}

// Returns the image, a JPEG at 1 / reduction of its size; empty if it cannot be decoded.
cv::Mat decoded(std::string_view bytes, ImageFormat format, Channels channels, int reduction) {
    const bool is_grey = channels == Channels::Grey;
    if (format == ImageFormat::Png)
        if (const auto plain = decode_grey_png(bytes)) {
            cv::Mat image = *plain;
            if (!is_grey) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
            return image;
        }
    static_assert(cv::IMREAD_REDUCED_GRAYSCALE_2 == 8 * 2 &&
                  cv::IMREAD_REDUCED_GRAYSCALE_8 == 8 * 8);
    const int mode = (is_grey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR) |
                     cv::IMREAD_IGNORE_ORIENTATION |
                     (format == ImageFormat::Jpeg && reduction > 1 ? 8 * reduction : 0);
    const cv::Mat buffer(
        1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    try {
        return cv::imdecode(buffer, mode);
    } catch (const cv::Exception&) {
        return {};
    }
}

}  // namespace

ImageHeader read_image_header(std::string_view bytes) {
    ImageHeader header;
    if (bytes.empty()) fail("the file is empty");
    if (bytes.starts_with(kPngSignature))
        header = read_png_header(bytes);
    else if (bytes.starts_with("\xff\xd8\xff"))
        header = read_jpeg_header(bytes);
    else
        fail_as_foreign(bytes);
    if (header.width_px <= 0 || header.height_px <= 0) fail("its header states 0 pixels");
    if (header.num_channels != 1 && header.num_channels != 3)
        fail("it has " + std::to_string(header.num_channels) + " channels, neither grey nor RGB");
    return header;
}

cv::Mat decode_image(std::string_view bytes,
                     const ImageHeader& header,
                     Channels channels,
                     int reduction) {
    const cv::Size whole(static_cast<int>(header.width_px), static_cast<int>(header.height_px));
    const cv::Size size(whole.width / reduction, whole.height / reduction);
    cv::Mat image = decoded(bytes, header.format, channels, reduction);
    if (image.size() == size) return image;
    if (image.size() == whole) return camera::reduced_image(image, reduction);
    // libjpeg rounds the size up.
    const bool is_rounded_up = image.cols == (whole.width + reduction - 1) / reduction &&
                               image.rows == (whole.height + reduction - 1) / reduction;
    if (!is_rounded_up) fail("its data is damaged or incomplete");
    return image(cv::Rect({}, size));
}

}  // namespace divemesh::dive
