#include "worker/io/raster_reader.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <tiffio.h>

#include "schemas/error.hpp"

namespace divemesh::io {
namespace {

constexpr std::uint32_t kMaxSide_px = 1U << 20;
constexpr std::uint32_t kMaxTile_px = 4096;

// libtiff prints errors unless a handler says that it took care of them.
int ignore(TIFF*, void*, const char*, const char*, va_list) { return 1; }

TIFF* open_quietly(const std::filesystem::path& file) {
    const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
        TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), ignore, nullptr);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore, nullptr);
    return TIFFOpenExt(file.c_str(), "r", options.get());
}

}  // namespace

RasterReader::RasterReader(const std::filesystem::path& file, int max_side_px)
    : file_(file), tiff_(nullptr, TIFFClose) {
    if (!std::filesystem::exists(file))
        throw Error(
            ErrorCode::NotFound,
            "no " + file.string() +
                ": copy the whole reconstruction, or reconstruct the dive with its texture");
    tiff_.reset(open_quietly(file));
    if (!tiff_) fail();
    read_layout();
    while (std::max(size_.width, size_.height) > max_side_px) {
        if (TIFFReadDirectory(tiff_.get()) == 0) fail();
        read_layout();
    }
}

void RasterReader::fail() const {
    throw Error(ErrorCode::BadData,
                file_.string() + " is not the raster that divemesh wrote: reconstruct again");
}

void RasterReader::read_layout() {
    std::uint32_t width_px = 0;
    std::uint32_t height_px = 0;
    std::uint32_t tile_px = 0;
    std::uint32_t tile_height_px = 0;
    std::uint16_t num_samples = 0;
    std::uint16_t num_bits = 0;
    TIFF* const from = tiff_.get();
    if (TIFFGetField(from, TIFFTAG_IMAGEWIDTH, &width_px) == 0 ||
        TIFFGetField(from, TIFFTAG_IMAGELENGTH, &height_px) == 0 ||
        TIFFGetField(from, TIFFTAG_TILEWIDTH, &tile_px) == 0 ||
        TIFFGetField(from, TIFFTAG_TILELENGTH, &tile_height_px) == 0 ||
        TIFFGetField(from, TIFFTAG_SAMPLESPERPIXEL, &num_samples) == 0 ||
        TIFFGetField(from, TIFFTAG_BITSPERSAMPLE, &num_bits) == 0)
        fail();
    const bool is_color = num_samples == 4 && num_bits == 8;
    const bool is_float = num_samples == 1 && num_bits == 32;
    if (std::max(width_px, height_px) > kMaxSide_px || tile_px != tile_height_px ||
        tile_px > kMaxTile_px || !(is_color || is_float))
        fail();
    size_ = {static_cast<int>(width_px), static_cast<int>(height_px)};
    type_ = is_color ? CV_8UC4 : CV_32FC1;
    tile_px_ = static_cast<int>(tile_px);
}

cv::Mat RasterReader::rows(int first_row, int num_rows) {
    cv::Mat out(num_rows, size_.width, type_);
    cv::Mat tile(tile_px_, tile_px_, type_);
    const auto num_bytes = static_cast<tmsize_t>(tile.total() * tile.elemSize());
    if (TIFFTileSize64(tiff_.get()) != static_cast<std::uint64_t>(num_bytes)) fail();
    for (int row = first_row / tile_px_ * tile_px_; row < first_row + num_rows; row += tile_px_)
        for (int column = 0; column < size_.width; column += tile_px_) {
            const std::uint32_t index = TIFFComputeTile(tiff_.get(),
                                                        static_cast<std::uint32_t>(column),
                                                        static_cast<std::uint32_t>(row),
                                                        0,
                                                        0);
            if (TIFFReadEncodedTile(tiff_.get(), index, tile.data, num_bytes) != num_bytes) fail();
            const cv::Rect wanted = cv::Rect(column, row, tile_px_, tile_px_) &
                                    cv::Rect(0, first_row, size_.width, num_rows);
            const cv::Mat source = tile(wanted - cv::Point(column, row));
            const cv::Mat target = out(wanted - cv::Point(0, first_row));
            if (type_ == CV_8UC4)
                cv::cvtColor(source, target, cv::COLOR_RGBA2BGRA);
            else
                source.copyTo(target);
        }
    return out;
}

}  // namespace divemesh::io
