#include "worker/io/geotiff_writer.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <geotiff/geotiff.h>
#include <geotiff/geovalues.h>
#include <geotiff/xtiffio.h>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"

namespace divemesh::io {
namespace {

constexpr int kTile_px = 256;
constexpr ttag_t kGdalNoData = 42113;  // the tag for "no data" in GDAL and QGIS

// A file in memory, which libtiff reads and writes at random; it is written to disk as a whole.
struct MemoryFile {
    std::string bytes;
    std::size_t position = 0;
};

MemoryFile& file_of(thandle_t handle) { return *static_cast<MemoryFile*>(handle); }

tmsize_t read(thandle_t handle, void* buffer, tmsize_t size) {
    MemoryFile& file = file_of(handle);
    const std::size_t left =
        file.position < file.bytes.size() ? file.bytes.size() - file.position : 0;
    const std::size_t count = std::min(left, static_cast<std::size_t>(size));
    std::memcpy(buffer, file.bytes.data() + file.position, count);
    file.position += count;
    return static_cast<tmsize_t>(count);
}

tmsize_t write(thandle_t handle, void* buffer, tmsize_t size) {
    MemoryFile& file = file_of(handle);
    const std::size_t end = file.position + static_cast<std::size_t>(size);
    if (file.bytes.size() < end) file.bytes.resize(end);
    std::memcpy(file.bytes.data() + file.position, buffer, static_cast<std::size_t>(size));
    file.position = end;
    return size;
}

toff_t seek(thandle_t handle, toff_t offset, int whence) {
    MemoryFile& file = file_of(handle);
    const std::size_t from = whence == SEEK_SET   ? 0
                             : whence == SEEK_CUR ? file.position
                                                  : file.bytes.size();
    file.position = from + offset;
    return file.position;
}

int close(thandle_t) { return 0; }
toff_t size(thandle_t handle) { return file_of(handle).bytes.size(); }
int map(thandle_t, void**, toff_t*) { return 0; }
void unmap(thandle_t, void*, toff_t) {}

struct Close {
    void operator()(TIFF* tiff) const { XTIFFClose(tiff); }
    void operator()(GTIF* keys) const { GTIFFree(keys); }
};

void set_layout(TIFF* tiff, const cv::Mat& raster) {
    const bool is_color = raster.type() == CV_8UC4;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(raster.cols));
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(raster.rows));
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, static_cast<std::uint32_t>(kTile_px));
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, static_cast<std::uint32_t>(kTile_px));
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, is_color ? 4 : 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, is_color ? 8 : 32);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, is_color ? SAMPLEFORMAT_UINT : SAMPLEFORMAT_IEEEFP);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, is_color ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    TIFFSetField(
        tiff, TIFFTAG_PREDICTOR, is_color ? PREDICTOR_HORIZONTAL : PREDICTOR_FLOATINGPOINT);
    if (is_color) {
        std::uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &alpha);
        return;
    }
    static const TIFFFieldInfo kNoData[] = {
        {kGdalNoData, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("GDALNoData")}};
    TIFFMergeFieldInfo(tiff, kNoData, 1);
    TIFFSetField(tiff, kGdalNoData, "nan");
}

void set_frame(TIFF* tiff, const RasterFrame& frame) {
    const auto& A = frame.A;
    // clang-format off
    std::array<double, 16> matrix = {A(0, 0), A(0, 1), 0, A(0, 2),
                                     A(1, 0), A(1, 1), 0, A(1, 2),
                                     0,       0,       0, 0,
                                     0,       0,       0, 1};
    // clang-format on
    TIFFSetField(tiff, TIFFTAG_GEOTRANSMATRIX, static_cast<int>(matrix.size()), matrix.data());
    const std::unique_ptr<GTIF, Close> keys(GTIFNew(tiff));
    if (!keys) throw Error(ErrorCode::OutOfMemory, "there is no memory for the keys of a GeoTIFF");
    GTIFKeySet(keys.get(), GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeProjected);
    GTIFKeySet(keys.get(), GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
    GTIFKeySet(keys.get(), ProjectedCSTypeGeoKey, TYPE_SHORT, 1, frame.epsg);
    GTIFKeySet(keys.get(), GTCitationGeoKey, TYPE_ASCII, 0, frame.citation.c_str());
    GTIFWriteKeys(keys.get());
}

// Returns the tile at (column, row); outside the raster it is filled with the no-data value 0.
cv::Mat tile_at(const cv::Mat& raster, int column, int row) {
    cv::Mat tile(kTile_px, kTile_px, raster.type(), cv::Scalar::all(0));
    const cv::Rect inside(column,
                          row,
                          std::min(kTile_px, raster.cols - column),
                          std::min(kTile_px, raster.rows - row));
    const cv::Mat target = tile(cv::Rect({0, 0}, inside.size()));
    if (raster.type() == CV_8UC4)
        cv::cvtColor(raster(inside), target, cv::COLOR_BGRA2RGBA);
    else
        raster(inside).copyTo(target);
    return tile;
}

}  // namespace

void write_geotiff(const std::filesystem::path& file,
                   const cv::Mat& raster,
                   const RasterFrame& frame) {
    if (raster.type() != CV_8UC4 && raster.type() != CV_32FC1)
        throw Error(ErrorCode::InvalidArgument, "a GeoTIFF needs a BGRA image or heights");
    MemoryFile memory;
    const std::unique_ptr<TIFF, Close> tiff(XTIFFClientOpen(
        file.filename().c_str(), "w", &memory, read, write, seek, close, size, map, unmap));
    if (!tiff) throw Error(ErrorCode::OutOfMemory, "there is no memory for " + file.string());
    set_layout(tiff.get(), raster);
    set_frame(tiff.get(), frame);
    for (int row = 0; row < raster.rows; row += kTile_px)
        for (int column = 0; column < raster.cols; column += kTile_px) {
            cv::Mat tile = tile_at(raster, column, row);
            if (TIFFWriteTile(tiff.get(),
                              tile.data,
                              static_cast<std::uint32_t>(column),
                              static_cast<std::uint32_t>(row),
                              0,
                              0) < 0)
                throw Error(ErrorCode::OutOfMemory, "cannot pack " + file.string());
        }
    if (TIFFFlush(tiff.get()) == 0)
        throw Error(ErrorCode::OutOfMemory, "cannot pack " + file.string());
    base::write_file(file, memory.bytes);
}

}  // namespace divemesh::io
