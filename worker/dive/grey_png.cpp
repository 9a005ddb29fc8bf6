#include "worker/dive/grey_png.hpp"

#include <algorithm>
#include <cstdint>
#include <libdeflate.h>
#include <memory>
#include <vector>

#include "worker/dive/big_endian.hpp"
#include "worker/dive/undo_paeth.hpp"

namespace divemesh::dive {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
constexpr std::size_t kChunkFrame = 12;  // length, type, checksum
constexpr int kPaeth = 4;                // the most common filter in photographs
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30;

struct Chunk {
    std::string_view type;
    std::string_view data;
};

// Takes the next chunk from the front; nullopt if it is truncated or its checksum is wrong.
std::optional<Chunk> take_chunk(std::string_view& bytes) {
    if (bytes.size() < kChunkFrame) return std::nullopt;
    const auto length = static_cast<std::size_t>(big_endian(bytes, 0, 4));
    if (length > bytes.size() - kChunkFrame) return std::nullopt;
    const std::string_view checked = bytes.substr(4, 4 + length);
    if (libdeflate_crc32(0, checked.data(), checked.size()) != big_endian(bytes, 8 + length, 4))
        return std::nullopt;
    bytes.remove_prefix(kChunkFrame + length);
    return Chunk{checked.substr(0, 4), checked.substr(4)};
}

// Undoes a row's filter (PNG specification 9.2); `above` is black before the first row. Returns
// false if the filter does not exist.
bool unfilter(int filter,
              const std::uint8_t* filtered,
              const std::uint8_t* above,
              int width,
              const PaethRows& paeth,
              std::uint8_t* row) {
    const auto add = [&](int u, int predicted) {
        row[u] = static_cast<std::uint8_t>(filtered[u] + predicted);
    };
    add(0, filter == 2 ? above[0] : filter == 3 ? above[0] / 2 : 0);
    switch (filter) {
        case 0:
            for (int u = 1; u < width; ++u) add(u, 0);
            return true;
        case 1:
            for (int u = 1; u < width; ++u) add(u, row[u - 1]);
            return true;
        case 2:
            for (int u = 1; u < width; ++u) add(u, above[u]);
            return true;
        case 3:
            for (int u = 1; u < width; ++u) add(u, (row[u - 1] + above[u]) / 2);
            return true;
        case kPaeth: paeth.undo(filtered, above, row); return true;
        default: return false;
    }
}

bool unpack(const std::vector<char>& packed, std::vector<std::uint8_t>& raw) {
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
        decompressor(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
    // Without a variable for the size, any size other than that of `raw` is an error.
    return decompressor &&
           libdeflate_zlib_decompress(
               decompressor.get(), packed.data(), packed.size(), raw.data(), raw.size(), nullptr) ==
               LIBDEFLATE_SUCCESS;
}

// Undoes the filters of all rows, each of which follows a byte that names its filter. Returns false
// if one does not exist.
bool unfilter(const std::vector<std::uint8_t>& raw, cv::Mat& image) {
    const auto step = static_cast<std::size_t>(image.cols) + 1;
    const std::vector<std::uint8_t> black(static_cast<std::size_t>(image.cols), 0);
    PaethRows paeth(image.cols);
    const int max_paeth = image.cols <= PaethRows::kMaxWidth ? PaethRows::kNumRows : 0;
    int num_paeth = 0;  // rows from v on
    for (int v = 0; v < image.rows;) {
        const std::uint8_t* filtered = raw.data() + static_cast<std::size_t>(v) * step;
        const std::uint8_t* above = v == 0 ? black.data() : image.ptr<std::uint8_t>(v - 1);
        auto* row = image.ptr<std::uint8_t>(v);
        while (num_paeth < max_paeth && v + num_paeth < image.rows &&
               filtered[static_cast<std::size_t>(num_paeth) * step] == kPaeth)
            ++num_paeth;
        if (num_paeth == PaethRows::kNumRows) {
            paeth.undo_eight(filtered + 1, step, above, row, image.step[0]);
            v += PaethRows::kNumRows;
            num_paeth = 0;
            continue;
        }
        if (!unfilter(filtered[0], filtered + 1, above, image.cols, paeth, row)) return false;
        num_paeth = std::max(0, num_paeth - 1);
        ++v;
    }
    return true;
}

}  // namespace

std::optional<cv::Mat> decode_grey_png(std::string_view bytes) {
    if (!bytes.starts_with(kSignature)) return std::nullopt;
    bytes.remove_prefix(kSignature.size());
    const auto header = take_chunk(bytes);
    if (!header || header->type != "IHDR" || header->data.size() != 13) return std::nullopt;
    // 8 bits, grey, deflate, the five standard filters, not interlaced.
    if (header->data.substr(8) != std::string_view("\x08\0\0\0\0", 5)) return std::nullopt;
    const std::int64_t width = big_endian(header->data, 0, 4);
    const std::int64_t height = big_endian(header->data, 4, 4);
    if (width < 1 || height < 1 || width > kMaxPixels / height) return std::nullopt;

    std::vector<char> packed;
    packed.reserve(bytes.size());
    for (;;) {
        const auto chunk = take_chunk(bytes);
        if (!chunk) return std::nullopt;
        if (chunk->type == "IEND") break;
        if (chunk->type == "IDAT")
            packed.insert(packed.end(), chunk->data.begin(), chunk->data.end());
    }
    std::vector<std::uint8_t> raw(static_cast<std::size_t>(height * (width + 1)));
    if (!unpack(packed, raw)) return std::nullopt;

    cv::Mat image(static_cast<int>(height), static_cast<int>(width), CV_8UC1);
    if (!unfilter(raw, image)) return std::nullopt;
    return image;
}

}  // namespace divemesh::dive
