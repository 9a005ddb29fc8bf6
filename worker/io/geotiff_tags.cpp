#include "worker/io/geotiff_tags.hpp"

#include <array>
#include <cstdint>
#include <tiff.h>
#include <vector>

namespace divemesh::io {
namespace {

constexpr std::uint16_t kGdalNoData = 42113;  // the tag for "no data" in GDAL and QGIS

// Tags of GeoTIFF, which tiff.h does not name.
constexpr std::uint16_t kModelPixelScale = 33550;
constexpr std::uint16_t kModelTiepoint = 33922;
constexpr std::uint16_t kModelTransformation = 34264;
constexpr std::uint16_t kGeoKeyDirectory = 34735;
constexpr std::uint16_t kGeoAsciiParams = 34737;

// Keys of GeoTIFF and their values.
constexpr int kModelType = 1024;
constexpr int kProjected = 1;
constexpr int kUserDefined = 32767;
constexpr int kRasterType = 1025;
constexpr int kPixelIsArea = 1;
constexpr int kCitation = 1026;
constexpr int kProjectedSystem = 3072;
constexpr int kLinearUnits = 3076;
constexpr int kMetre = 9001;

void set_place(TiffDirectory& directory, const RasterFrame& frame) {
    const auto& A = frame.A;
    if (A(0, 1) == 0.0 && A(1, 0) == 0.0 && A(1, 1) < 0.0) {
        directory.set_doubles(kModelPixelScale, {A(0, 0), -A(1, 1), 0.0});
        directory.set_doubles(kModelTiepoint, {0.0, 0.0, 0.0, A(0, 2), A(1, 2), 0.0});
        return;
    }
    // clang-format off
    directory.set_doubles(kModelTransformation, {A(0, 0), A(0, 1), 0, A(0, 2),
                                                 A(1, 0), A(1, 1), 0, A(1, 2),
                                                 0,       0,       0, 0,
                                                 0,       0,       0, 1});
    // clang-format on
}

}  // namespace

void set_raster_tags(TiffDirectory& directory, const cv::Size& size, int type, int tile_px) {
    const bool is_color = type == CV_8UC4;
    const auto num_samples = static_cast<std::uint16_t>(is_color ? 4 : 1);
    const auto per_sample = [&](int value) {
        return std::vector<std::uint16_t>(num_samples, static_cast<std::uint16_t>(value));
    };
    const auto tile = static_cast<std::uint16_t>(tile_px);
    directory.set_longs(TIFFTAG_IMAGEWIDTH, {static_cast<std::uint32_t>(size.width)});
    directory.set_longs(TIFFTAG_IMAGELENGTH, {static_cast<std::uint32_t>(size.height)});
    directory.set_shorts(TIFFTAG_TILEWIDTH, {tile});
    directory.set_shorts(TIFFTAG_TILELENGTH, {tile});
    directory.set_shorts(TIFFTAG_COMPRESSION, {COMPRESSION_ADOBE_DEFLATE});
    directory.set_shorts(TIFFTAG_PLANARCONFIG, {PLANARCONFIG_CONTIG});
    directory.set_shorts(TIFFTAG_SAMPLESPERPIXEL, {num_samples});
    directory.set_shorts(TIFFTAG_BITSPERSAMPLE, per_sample(is_color ? 8 : 32));
    directory.set_shorts(TIFFTAG_SAMPLEFORMAT,
                         per_sample(is_color ? SAMPLEFORMAT_UINT : SAMPLEFORMAT_IEEEFP));
    const int photometric = is_color ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    directory.set_shorts(TIFFTAG_PHOTOMETRIC, {static_cast<std::uint16_t>(photometric)});
    const int predictor = is_color ? PREDICTOR_HORIZONTAL : PREDICTOR_FLOATINGPOINT;
    directory.set_shorts(TIFFTAG_PREDICTOR, {static_cast<std::uint16_t>(predictor)});
    if (is_color)
        directory.set_shorts(TIFFTAG_EXTRASAMPLES, {EXTRASAMPLE_UNASSALPHA});
    else
        directory.set_text(kGdalNoData, "nan");
}

void set_frame_tags(TiffDirectory& directory, const RasterFrame& frame) {
    set_place(directory, frame);
    const bool is_local = frame.epsg == RasterFrame::kLocal;
    const std::string citation = frame.citation + "|";
    struct GeoKey {
        int key = 0;
        int tag = 0;  // 0: the value is in its place
        std::size_t count = 1;
        int value = 0;
    };
    const std::array<GeoKey, 4> keys = {{
        {kModelType, 0, 1, is_local ? kUserDefined : kProjected},
        {kRasterType, 0, 1, kPixelIsArea},
        {kCitation, kGeoAsciiParams, citation.size(), 0},
        is_local ? GeoKey{kLinearUnits, 0, 1, kMetre} : GeoKey{kProjectedSystem, 0, 1, frame.epsg},
    }};
    std::vector<std::uint16_t> values = {1, 1, 0, keys.size()};  // version 1, revision 1.0
    for (const GeoKey& key : keys) {
        values.push_back(static_cast<std::uint16_t>(key.key));
        values.push_back(static_cast<std::uint16_t>(key.tag));
        values.push_back(static_cast<std::uint16_t>(key.count));
        values.push_back(static_cast<std::uint16_t>(key.value));
    }
    directory.set_shorts(kGeoKeyDirectory, values);
    directory.set_text(kGeoAsciiParams, citation);
}

}  // namespace divemesh::io
