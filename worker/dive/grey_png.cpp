#include "worker/dive/grey_png.hpp"

#include <algorithm>
#include <cstdint>
#include <libdeflate.h>
#include <memory>
#include <vector>

#include "worker/dive/big_endian.hpp"

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

// PNG specification 9.4: returns the one of a, b, c (left, above, left above) that is nearest to a
// + b - c. Has no branches, which would be mispredicted on noise (as in stb_image).
int paeth(int a, int b, int c) {
    const int low = std::min(a, b);
    const int high = std::max(a, b);
    const int threshold = 3 * c - (a + b);
    const int inner = high <= threshold ? low : c;
    return threshold <= low ? high : inner;
}

// A row while its filter is undone; each pixel depends on the one to its left.
struct PaethRow {
    const std::uint8_t* filtered;
    const std::uint8_t* above;
    std::uint8_t* row;
    int left = 0;
    int left_above = 0;

    void step(int u) {
        left = (filtered[u] + paeth(left, above[u], left_above)) & 0xff;
        left_above = above[u];
        row[u] = static_cast<std::uint8_t>(left);
    }
};

void undo_paeth(PaethRow row, int width) {
    for (int u = 0; u < width; ++u) row.step(u);
}

// Processes two rows, the lower one a pixel behind, so that neither waits for the other.
void undo_paeth(PaethRow upper, PaethRow lower, int width) {
    upper.step(0);
    for (int u = 1; u < width; ++u) {
        upper.step(u);
        lower.step(u - 1);
    }
    lower.step(width - 1);
}

// Undoes a row's filter (PNG specification 9.2); `above` is black before the first row. Returns
// false if the filter does not exist.
bool unfilter(int filter,
              const std::uint8_t* filtered,
              const std::uint8_t* above,
              int width,
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
        case kPaeth: undo_paeth(PaethRow{filtered, above, row}, width); return true;
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
    const std::vector<std::uint8_t> black(static_cast<std::size_t>(width), 0);
    const auto filtered = [&](int v) { return raw.data() + v * (width + 1); };
    for (int v = 0; v < image.rows; ++v) {
        const std::uint8_t* above = v == 0 ? black.data() : image.ptr<std::uint8_t>(v - 1);
        auto* row = image.ptr<std::uint8_t>(v);
        if (v + 1 < image.rows && filtered(v)[0] == kPaeth && filtered(v + 1)[0] == kPaeth) {
            undo_paeth(PaethRow{filtered(v) + 1, above, row},
                       PaethRow{filtered(v + 1) + 1, row, image.ptr<std::uint8_t>(v + 1)},
                       image.cols);
            ++v;
        } else if (!unfilter(filtered(v)[0], filtered(v) + 1, above, image.cols, row)) {
            return std::nullopt;
        }
    }
    return image;
}

}  // namespace divemesh::dive
