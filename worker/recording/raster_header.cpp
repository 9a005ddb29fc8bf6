#include "worker/recording/raster_header.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "schemas/error.hpp"
#include "worker/dive/csv.hpp"
#include "worker/recording/byte_cursor.hpp"
#include "worker/recording/tiff_fields.hpp"

namespace divemesh::recording {
namespace {

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

RasterHeader tiff_header(const TiffFields& fields) {
    constexpr std::uint16_t kWidth = 256;
    constexpr std::uint16_t kHeight = 257;
    const auto number = [&](std::uint16_t tag) {
        const auto field = fields.find(tag);
        const auto value = field ? fields.number(*field) : std::nullopt;
        return static_cast<std::int64_t>(value.value_or(0));
    };
    return {number(kWidth), number(kHeight), 0};
}

// Reads BITMAPINFOHEADER, or BITMAPCOREHEADER of 12 bytes with its short sizes.
RasterHeader bmp_header(std::string_view bytes) {
    constexpr std::size_t kFileHeader_bytes = 14;
    constexpr std::uint32_t kCoreHeader_bytes = 12;
    ByteCursor cursor(bytes.substr(std::min(bytes.size(), kFileHeader_bytes)));
    const auto size_bytes = cursor.take<std::uint32_t>();
    if (size_bytes == kCoreHeader_bytes) {
        const auto width = cursor.take<std::uint16_t>();
        const auto height = cursor.take<std::uint16_t>();
        return {width.value_or(0), height.value_or(0), 0};
    }
    const auto width = cursor.take<std::int32_t>();
    const auto height = cursor.take<std::int32_t>();  // below 0: the first row is the upper one
    return {width.value_or(0), std::abs(std::int64_t{height.value_or(0)}), 0};
}

// Takes the next number of a PNM's header; comments go from # to the end of the line.
std::int64_t take_number(std::string_view& bytes) {
    constexpr std::string_view kBlank = " \t\r\n\v\f";
    while (!bytes.empty() &&
           (kBlank.find(bytes.front()) != std::string_view::npos || bytes.front() == '#')) {
        const bool is_comment = bytes.front() == '#';
        bytes.remove_prefix(is_comment ? std::min(bytes.find('\n'), bytes.size()) : 1);
    }
    const std::size_t end = std::min(bytes.find_first_not_of("0123456789"), bytes.size());
    const auto number = dive::parse_integer(bytes.substr(0, end));
    bytes.remove_prefix(end);
    return number.value_or(0);
}

RasterHeader pnm_header(std::string_view bytes) {
    bytes.remove_prefix(2);
    RasterHeader header;
    header.width_px = take_number(bytes);
    header.height_px = take_number(bytes);
    header.max_value = take_number(bytes);
    if (header.max_value < 1 || header.max_value > 65535) fail("its largest value is not stated");
    return header;
}

bool is_pnm(std::string_view bytes) {
    constexpr std::string_view kKinds = "2356";  // grey or colour, as text or bytes
    return bytes.size() > 2 && bytes[0] == 'P' && kKinds.find(bytes[1]) != std::string_view::npos;
}

RasterHeader header_of(std::string_view bytes) {
    if (const auto fields = TiffFields::of(bytes)) return tiff_header(*fields);
    if (bytes.starts_with("BM")) return bmp_header(bytes);
    if (is_pnm(bytes)) return pnm_header(bytes);
    fail("it is neither PNG, JPEG, TIFF, BMP, PGM nor PPM");
}

}  // namespace

RasterHeader read_raster_header(std::string_view bytes) {
    const RasterHeader header = header_of(bytes);
    if (header.width_px <= 0 || header.height_px <= 0) fail("its header states no size");
    return header;
}

}  // namespace divemesh::recording
