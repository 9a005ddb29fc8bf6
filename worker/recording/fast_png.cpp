#include "worker/recording/fast_png.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <libdeflate.h>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::recording {
namespace {

constexpr int kLevel = 1;
constexpr std::uint8_t kSub = 1;  // each byte less that of the pixel before

struct FreeCompressor {
    void operator()(libdeflate_compressor* compressor) const {
        libdeflate_free_compressor(compressor);
    }
};

void put_big_endian(std::uint32_t value, std::string& bytes) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xffU);
}

void put_chunk(std::string_view type, std::string_view data, std::string& file) {
    put_big_endian(static_cast<std::uint32_t>(data.size()), file);
    const std::size_t begin = file.size();
    file.append(type).append(data);
    put_big_endian(libdeflate_crc32(0, file.data() + begin, file.size() - begin), file);
}

// Returns the pixels as a PNG orders their bytes: R G B, numbers of 16 bits with the high one
// first.
cv::Mat in_order_of_png(const cv::Mat& image) {
    cv::Mat ordered;
    if (image.channels() == 3)
        cv::cvtColor(image, ordered, cv::COLOR_BGR2RGB);
    else
        ordered = image.depth() == CV_16U ? image.clone() : image;
    if (image.depth() != CV_16U) return ordered;
    for (int y = 0; y < ordered.rows; ++y) {
        auto* row = ordered.ptr<std::uint16_t>(y);
        for (int i = 0; i < ordered.cols * ordered.channels(); ++i)
            row[i] = static_cast<std::uint16_t>(row[i] << 8 | row[i] >> 8);
    }
    return ordered;
}

// Returns each row behind the number of its filter.
std::vector<std::uint8_t> filtered(const cv::Mat& image) {
    const std::size_t pixel_bytes = image.elemSize();
    const std::size_t row_bytes = pixel_bytes * static_cast<std::size_t>(image.cols);
    std::vector<std::uint8_t> rows((row_bytes + 1) * static_cast<std::size_t>(image.rows));
    for (int y = 0; y < image.rows; ++y) {
        const auto* from = image.ptr<std::uint8_t>(y);
        std::uint8_t* to = rows.data() + (row_bytes + 1) * static_cast<std::size_t>(y);
        *to++ = kSub;
        std::memcpy(to, from, pixel_bytes);
        for (std::size_t i = pixel_bytes; i < row_bytes; ++i)
            to[i] = static_cast<std::uint8_t>(from[i] - from[i - pixel_bytes]);
    }
    return rows;
}

std::string compressed(const std::vector<std::uint8_t>& bytes) {
    const std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor(
        libdeflate_alloc_compressor(kLevel));
    if (compressor == nullptr)
        throw Error(ErrorCode::Unavailable, "no memory to compress an image: free memory");
    std::string packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()), '\0');
    packed.resize(libdeflate_zlib_compress(
        compressor.get(), bytes.data(), bytes.size(), packed.data(), packed.size()));
    return packed;
}

}  // namespace

std::string fast_png(const cv::Mat& image) {
    static_assert(std::endian::native == std::endian::little);
    constexpr char kGrey = 0;
    constexpr char kRgb = 2;
    std::string header;
    put_big_endian(static_cast<std::uint32_t>(image.cols), header);
    put_big_endian(static_cast<std::uint32_t>(image.rows), header);
    header += static_cast<char>(8 * image.elemSize1());
    header += image.channels() == 3 ? kRgb : kGrey;
    header.append(3, '\0');  // compression, filters, no interlace
    std::string file("\x89PNG\r\n\x1a\n");
    put_chunk("IHDR", header, file);
    put_chunk("IDAT", compressed(filtered(in_order_of_png(image))), file);
    put_chunk("IEND", "", file);
    return file;
}

}  // namespace divemesh::recording
