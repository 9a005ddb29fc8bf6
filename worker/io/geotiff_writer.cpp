#include "worker/io/geotiff_writer.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <tiff.h>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/base/parallel.hpp"
#include "worker/io/geotiff_tags.hpp"
#include "worker/io/half_size.hpp"
#include "worker/io/raster_tile.hpp"

namespace divemesh::io {
namespace {

constexpr int kTile_px = 256;
constexpr std::uint64_t kMaxClassicBytes = std::numeric_limits<std::uint32_t>::max();

// What GDAL looks for behind the header to read a file over a network in few requests.
constexpr std::string_view kLayout =
    "LAYOUT=IFDS_BEFORE_DATA\nBLOCK_ORDER=ROW_MAJOR\nBLOCK_LEADER=SIZE_AS_UINT4\n"
    "BLOCK_TRAILER=LAST_4_BYTES_REPEATED\nKNOWN_INCOMPATIBLE_EDITION=NO\n ";
constexpr std::size_t kLeaderBytes = 4;
constexpr std::size_t kTrailerBytes = 4;

int num_tiles(int length_px) { return (length_px + kTile_px - 1) / kTile_px; }

cv::Scalar unknown(int type) {
    return cv::Scalar::all(type == CV_8UC4 ? 0.0 : std::numeric_limits<double>::quiet_NaN());
}

bool is_empty(const cv::Mat& tile) {
    if (tile.type() == CV_8UC4)
        return std::all_of(tile.begin<cv::Vec4b>(), tile.end<cv::Vec4b>(), [](const cv::Vec4b& p) {
            return p == cv::Vec4b();
        });
    return std::all_of(
        tile.begin<float>(), tile.end<float>(), [](float value) { return value != value; });
}

// Returns a tile with its leader and trailer.
std::string framed(const std::string& tile) {
    const auto num_bytes = static_cast<std::uint32_t>(tile.size());
    std::string bytes(reinterpret_cast<const char*>(&num_bytes), kLeaderBytes);
    bytes += tile;
    return bytes.append(tile, tile.size() - kTrailerBytes);
}

std::string header(TiffVariant variant) {
    using namespace std::string_literals;
    // Little-endian, then the offset of the first directory, which follows the layout.
    std::string bytes = variant == TiffVariant::Big ? "II\x2b\0\x08\0\0\0"s : "II\x2a\0"s;
    char layout_size[64];
    std::snprintf(layout_size,
                  sizeof layout_size,
                  "GDAL_STRUCTURAL_METADATA_SIZE=%06zu bytes\n",
                  kLayout.size());
    const std::string layout = layout_size + std::string(kLayout);
    std::uint64_t first = layout.size() + (variant == TiffVariant::Big ? 16 : 8);
    first += first % 2;
    bytes.append(reinterpret_cast<const char*>(&first), variant == TiffVariant::Big ? 8 : 4);
    bytes += layout;
    bytes.resize(first, '\0');
    return bytes;
}

}  // namespace

GeotiffWriter::GeotiffWriter(const std::filesystem::path& file,
                             const cv::Size& size,
                             int type,
                             const RasterFrame& frame,
                             int num_threads)
    : file_(file),
      type_(type),
      frame_(frame),
      num_threads_(num_threads),
      scratch_(file.has_parent_path() ? file.parent_path() : ".") {
    if (type != CV_8UC4 && type != CV_32FC1)
        throw Error(ErrorCode::InvalidArgument, "a GeoTIFF needs a BGRA image or heights");
    empty_tile_ = packed_tile(cv::Mat(kTile_px, kTile_px, type, unknown(type)));
    cv::Size of_level = size;
    levels_.push_back({.size = of_level});
    while (std::max(of_level.width, of_level.height) > kTile_px) {
        of_level = {(of_level.width + 1) / 2, (of_level.height + 1) / 2};
        levels_.push_back({.size = of_level});
    }
    for (Level& level : levels_)
        level.rows = cv::Mat(kTile_px, num_tiles(level.size.width) * kTile_px, type, unknown(type));
}

void GeotiffWriter::append(const cv::Mat& rows) { append_to(0, rows); }

void GeotiffWriter::append_to(std::size_t index, const cv::Mat& rows) {
    Level& level = levels_[index];
    for (int row = 0; row < rows.rows;) {
        const int count = std::min(rows.rows - row, kTile_px - level.num_rows);
        const cv::Rect target(0, level.num_rows, rows.cols, count);
        rows.rowRange(row, row + count).copyTo(level.rows(target));
        row += count;
        level.num_rows += count;
        const bool is_last = level.num_finished_rows + level.num_rows == level.size.height;
        if (level.num_rows == kTile_px || is_last) finish_tiles(index);
    }
}

void GeotiffWriter::finish_tiles(std::size_t index) {
    Level& level = levels_[index];
    level.rows.rowRange(level.num_rows, kTile_px).setTo(unknown(type_));
    for (const std::string& tile : packed_tiles(level.rows)) {
        const std::string stored = framed(tile);
        level.tiles.push_back({scratch_bytes_, static_cast<std::uint32_t>(stored.size())});
        scratch_.append(stored);
        scratch_bytes_ += stored.size();
    }
    if (index + 1 < levels_.size())
        append_to(index + 1,
                  half_size(level.rows(cv::Rect(0, 0, level.size.width, level.num_rows))));
    level.num_finished_rows += level.num_rows;
    level.num_rows = 0;
}

std::vector<std::string> GeotiffWriter::packed_tiles(const cv::Mat& rows) const {
    std::vector<std::string> tiles(static_cast<std::size_t>(rows.cols / kTile_px));
    base::for_each_index(num_threads_, tiles.size(), [&](std::size_t i) {
        const int column = static_cast<int>(i) * kTile_px;
        const cv::Mat tile = rows.colRange(column, column + kTile_px);
        tiles[i] = is_empty(tile) ? empty_tile_ : packed_tile(tile);
    });
    return tiles;
}

TiffDirectory GeotiffWriter::directory(std::size_t index,
                                       std::uint64_t first_tile,
                                       TiffVariant variant) const {
    TiffDirectory directory;
    set_raster_tags(directory, levels_[index].size, type_, kTile_px);
    if (index == 0)
        set_frame_tags(directory, frame_);
    else
        directory.set_longs(TIFFTAG_SUBFILETYPE, {FILETYPE_REDUCEDIMAGE});
    std::vector<std::uint64_t> offsets;
    std::vector<std::uint32_t> sizes;
    for (const StoredTile& tile : levels_[index].tiles) {
        offsets.push_back(first_tile + kLeaderBytes);
        sizes.push_back(tile.num_bytes - static_cast<std::uint32_t>(kLeaderBytes + kTrailerBytes));
        first_tile += tile.num_bytes;
    }
    directory.set_offsets(TIFFTAG_TILEOFFSETS, offsets, variant);
    directory.set_longs(TIFFTAG_TILEBYTECOUNTS, sizes);
    return directory;
}

// Returns what lies before the tiles.
std::string GeotiffWriter::head(TiffVariant variant) const {
    std::string bytes = header(variant);
    std::uint64_t place = bytes.size();
    for (std::size_t i = 0; i < levels_.size(); ++i)
        place += directory(i, 0, variant).num_bytes(variant);
    std::vector<std::uint64_t> first_tiles(levels_.size());
    for (std::size_t i = levels_.size(); i-- > 0;) {
        first_tiles[i] = place;
        for (const StoredTile& tile : levels_[i].tiles) place += tile.num_bytes;
    }
    for (std::size_t i = 0; i < levels_.size(); ++i) {
        const TiffDirectory described = directory(i, first_tiles[i], variant);
        const std::uint64_t end = bytes.size() + described.num_bytes(variant);
        bytes += described.bytes(variant, bytes.size(), i + 1 < levels_.size() ? end : 0);
    }
    return bytes;
}

void GeotiffWriter::commit() {
    std::string before_tiles = head(TiffVariant::Classic);
    if (before_tiles.size() + scratch_bytes_ > kMaxClassicBytes)
        before_tiles = head(TiffVariant::Big);
    base::AtomicFile output(file_);
    output.write(before_tiles);
    for (std::size_t i = levels_.size(); i-- > 0;)
        for (const StoredTile& tile : levels_[i].tiles)
            output.write(scratch_.read(tile.scratch_offset, tile.num_bytes));
    output.commit();
}

}  // namespace divemesh::io
