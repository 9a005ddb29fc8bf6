#include "worker/reef/read_outlines.hpp"

#include <fstream>
#include <iterator>

#include "schemas/error.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/reef/geojson_outlines.hpp"
#include "worker/reef/shapefile_outlines.hpp"
#include "worker/reef/taglab_outlines.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFile_bytes = 256U << 20U;  // a TagLab project of years

std::string read_bytes(const fs::path& file) {
    std::error_code error;
    const auto size = fs::file_size(file, error);
    std::ifstream stream(file, std::ios::binary);
    if (error || !stream)
        throw Error(ErrorCode::NotFound, "cannot be read: check the path of the areas");
    if (size > kMaxFile_bytes) throw Error(ErrorCode::BadData, "is larger than 256 MiB");
    return {std::istreambuf_iterator<char>(stream), {}};
}

// Returns the bytes of the file with another extension; empty if there is none.
std::string read_beside(fs::path file, const char* lower, const char* upper) {
    for (const char* extension : {lower, upper})
        if (fs::exists(file.replace_extension(extension))) return read_bytes(file);
    return "";
}

OutlineFile read_shapefile(const fs::path& file, const std::string& bytes) {
    const std::string table = read_beside(file, ".dbf", ".DBF");
    OutlineFile outlines = shapefile_outlines(bytes, table.empty() ? DbfTable{} : read_dbf(table));
    const std::string projection = read_beside(file, ".prj", ".PRJ");
    const int epsg = projection.empty() ? kLocalCoordinates : epsg_of(projection);
    if (epsg == 0)
        throw Error(ErrorCode::BadData,
                    "its coordinate system (.prj) is not read: save it in WGS 84 (EPSG:4326) or in "
                    "WGS 84 / UTM; it begins " +
                        json(projection.substr(0, 60))
                            .dump(-1, ' ', false, json::error_handler_t::replace));
    const bool is_local = epsg == kLocalCoordinates;
    outlines.coordinates = is_local ? OutlineCoordinates::World : OutlineCoordinates::Earth;
    outlines.epsg = is_local ? 0 : epsg;
    return outlines;
}

OutlineFile read_geojson(const json& document) {
    OutlineFile outlines = geojson_outlines(document);
    if (outlines.coordinates != OutlineCoordinates::Unstated) return outlines;
    outlines.coordinates = OutlineCoordinates::Earth;
    outlines.epsg = io::kLongitudeLatitudeEpsg;
    return outlines;
}

}  // namespace

std::variant<json, OutlineFile> read_outlines(const fs::path& file, const std::string& map) {
    const std::string bytes = read_bytes(file);
    if (is_shapefile(bytes)) return read_shapefile(file, bytes);
    json document = json::parse(bytes, nullptr, false);
    if (document.is_object()) {
        if (document.contains("areas")) return document;
        if (document.contains("type")) return read_geojson(document);
        if (document.contains("images")) return taglab_outlines(document, map);
    }
    throw Error(ErrorCode::BadData,
                "is no areas.json, GeoJSON, shapefile (.shp) or TagLab project: save the areas in "
                "one of these");
}

}  // namespace divemesh::reef
