#include "worker/reef/geojson_outlines.hpp"

#include <algorithm>
#include <cmath>

#include "schemas/error.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

// A collection in a collection in a collection ... is no file that a program wrote.
constexpr int kMaxDepth = 8;

class GeoJsonReader {
public:
    explicit GeoJsonReader(OutlineFile& file) : file_(file) {}

    void read(const json& document) {
        if (document.at("type") == "FeatureCollection") {
            for (const json& feature : list_of(document, "features")) read_feature(feature);
        } else {
            read_feature(document);
        }
    }

private:
    void read_feature(const json& feature) {
        Outline outline;
        outline.feature = num_features_++;
        const json* geometry = &feature;
        if (type_of(feature) == "Feature") {
            const auto properties = feature.find("properties");
            if (properties != feature.end() && properties->is_object())
                for (const auto& [key, value] : properties->items())
                    outline.columns[key] = text_of(value);
            geometry = feature.contains("geometry") ? &feature["geometry"] : nullptr;
        }
        if (geometry != nullptr && !geometry->is_null()) read_geometry(*geometry, outline, 0);
    }

    void read_geometry(const json& geometry, const Outline& feature, int depth) {
        const std::string type = type_of(geometry);
        if (type == "GeometryCollection") {
            if (depth == kMaxDepth) refuse("its collections are nested too deeply");
            for (const json& part : list_of(geometry, "geometries"))
                read_geometry(part, feature, depth + 1);
        } else if (type == "Polygon") {
            add_polygon(list_of(geometry, "coordinates"), feature);
        } else if (type == "MultiPolygon") {
            for (const json& part : list_of(geometry, "coordinates")) add_polygon(part, feature);
        } else if (type == "LineString") {
            add(list_of(geometry, "coordinates"), feature, true);
        } else if (type == "MultiLineString") {
            for (const json& part : list_of(geometry, "coordinates")) add(part, feature, true);
        } else if (type != "Point" && type != "MultiPoint") {
            refuse("'" + type + "' is no type of GeoJSON");
        }
    }

    void add_polygon(const json& rings, const Outline& feature) {
        if (!rings.is_array()) refuse("a polygon is not a list of rings");
        if (rings.empty()) return;
        add(rings[0], feature, false);
        file_.outlines.back().num_holes = static_cast<int>(rings.size()) - 1;
    }

    void add(const json& positions, Outline outline, bool is_line) {
        if (!positions.is_array()) refuse("its coordinates are not a list of positions");
        num_points_ += positions.size();
        if (num_points_ > kMaxOutlinePoints) refuse("the file has more than 5,000,000 points");
        outline.is_line = is_line;
        for (const json& position : positions) outline.points.push_back(point_of(position));
        file_.outlines.push_back(std::move(outline));
    }

    Eigen::Vector2d point_of(const json& position) const {
        if (!position.is_array() || position.size() < 2 || !position[0].is_number() ||
            !position[1].is_number())
            refuse("a position is not [x, y] or [x, y, z]");
        return {position[0].get<double>(), position[1].get<double>()};
    }

    std::string type_of(const json& object) const {
        const auto type = object.is_object() ? object.find("type") : object.end();
        if (type == object.end() || !type->is_string()) refuse("it has no type");
        return type->get<std::string>();
    }

    const json& list_of(const json& object, const char* key) const {
        const auto list = object.find(key);
        if (list == object.end() || !list->is_array())
            refuse(std::string("it has no list '") + key + "'");
        return *list;
    }

    static std::string text_of(const json& value) {
        if (value.is_null()) return "";
        return value.is_string() ? value.get<std::string>() : value.dump();
    }

    [[noreturn]] void refuse(const std::string& what) const {
        throw Error(
            ErrorCode::BadData,
            "feature " + std::to_string(std::max<std::size_t>(num_features_, 1)) + ": " + what);
    }

    OutlineFile& file_;
    std::size_t num_features_ = 0;
    std::size_t num_points_ = 0;
};

// Sets the coordinate system of the member "crs", which GeoJSON had until 2016.
void read_crs(const json& document, OutlineFile& file) {
    const json::json_pointer pointer("/crs/properties/name");
    if (!document.contains(pointer) || !document[pointer].is_string()) return;
    const auto name = document[pointer].get<std::string>();
    file.epsg = epsg_of(name);
    if (file.epsg <= 0)
        throw Error(ErrorCode::BadData,
                    "its coordinate system '" + name +
                        "' is not read: save it in WGS 84 (EPSG:4326) or in WGS 84 / UTM");
    file.coordinates = OutlineCoordinates::Earth;
}

}  // namespace

OutlineFile geojson_outlines(const json& document) {
    OutlineFile file;
    read_crs(document, file);
    GeoJsonReader(file).read(document);
    return file;
}

}  // namespace divemesh::reef
