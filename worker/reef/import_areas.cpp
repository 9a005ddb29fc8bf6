#include "worker/reef/import_areas.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>

#include "schemas/error.hpp"
#include "worker/reef/area_set.hpp"
#include "worker/reef/ground_heights.hpp"
#include "worker/reef/place_outlines.hpp"
#include "worker/reef/read_outlines.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

constexpr double kStepsPerM = 1e5;  // to which points are rounded

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

// Returns the first of these columns that states something, whatever its case is.
std::string column(const Outline& outline, const std::vector<std::string>& names) {
    for (const std::string& name : names)
        for (const auto& [key, value] : outline.columns)
            if (lower(key) == lower(name) && !value.empty()) return value;
    return "";
}

// Throws Error{InvalidArgument} if no outline has a column that was asked for.
void require_column(const OutlineFile& file, const std::string& name) {
    if (name.empty()) return;
    std::set<std::string> known;
    for (const Outline& outline : file.outlines)
        for (const auto& [key, value] : outline.columns) {
            if (lower(key) == lower(name)) return;
            known.insert(key);
        }
    std::string list;
    for (const std::string& key : known) list.append(list.empty() ? "" : ", ").append(key);
    throw Error(ErrorCode::InvalidArgument,
                "no column is called '" + name + "': choose one of " + list);
}

// Overrides the coordinates that the file states.
void override_coordinates(OutlineFile& file, const std::string& crs) {
    if (crs.empty()) return;
    file.epsg = crs == "world" ? 0 : epsg_of(crs);
    file.coordinates = crs == "world" ? OutlineCoordinates::World : OutlineCoordinates::Earth;
    if (crs != "world" && file.epsg <= 0)
        throw Error(ErrorCode::InvalidArgument,
                    "the coordinate system '" + crs +
                        "' is not known: give world, EPSG:4326, or EPSG:326zz or EPSG:327zz for "
                        "zone zz of UTM");
}

// Gives out names that are used once.
class UniqueNames {
public:
    std::string take(const std::string& wanted) {
        std::string name = wanted;
        for (int i = 2; !taken_.insert(name).second; ++i)
            name = wanted + " (" + std::to_string(i) + ")";
        return name;
    }

private:
    std::set<std::string> taken_;
};

// Rounds points and removes those that lie on the one before; of a ring also the repeated first.
Polygon without_repetition(const Polygon& points, bool is_line) {
    Polygon cleaned;
    for (const Eigen::Vector2d& point : points) {
        const Eigen::Vector2d rounded = (point * kStepsPerM).array().round() / kStepsPerM;
        if (cleaned.empty() || rounded != cleaned.back()) cleaned.push_back(rounded);
    }
    while (!is_line && cleaned.size() > 1 && cleaned.back() == cleaned.front()) cleaned.pop_back();
    return cleaned;
}

// Simplifies an outline of too many points, as contours of pixels are (Douglas and Peucker 1973),
// to the smallest of 0.1, 0.2, 0.4 ... mm that is enough.
Polygon thinned(const Polygon& points, bool is_line) {
    constexpr double kFirstTolerance_m = 1e-4;
    if (points.size() <= kMaxAreaPoints) return points;
    std::vector<cv::Point2f> near;  // the first point, where float is exact enough
    for (const Eigen::Vector2d& point : points) {
        const Eigen::Vector2d p_first = point - points.front();
        near.emplace_back(static_cast<float>(p_first.x()), static_cast<float>(p_first.y()));
    }
    std::vector<cv::Point2f> fewer = near;
    for (double tolerance_m = kFirstTolerance_m; fewer.size() > kMaxAreaPoints; tolerance_m *= 2.0)
        cv::approxPolyDP(near, fewer, tolerance_m, !is_line);
    Polygon thin;
    for (const cv::Point2f& point : fewer)
        thin.emplace_back(points.front() + Eigen::Vector2d(point.x, point.y));
    return without_repetition(thin, is_line);
}

std::string name_of(const Outline& outline, const AreaImport& how) {
    std::string name = column(outline,
                              how.name_column.empty() ? std::vector<std::string>{"name", "id"}
                                                      : std::vector{how.name_column});
    return name.empty() ? "area " + std::to_string(outline.feature + 1) : name;
}

std::string label_of(const Outline& outline, const AreaImport& how) {
    return column(outline,
                  how.label_column.empty()
                      ? std::vector<std::string>{"label", "class", "species", "TL_Class"}
                      : std::vector{how.label_column});
}

json area_of(const Outline& outline, std::string name, const GroundHeights& ground) {
    const bool is_quadrat = !outline.is_line && lower(column(outline, {"kind"})) == "quadrat";
    json points = json::array();
    for (const Eigen::Vector2d& point : outline.points)
        points.push_back(
            {point.x(), point.y(), std::round(ground.at(point) * kStepsPerM) / kStepsPerM});
    return {{"name", std::move(name)},
            {"kind",
             outline.is_line ? "transect"
             : is_quadrat    ? "quadrat"
                             : "polygon"},
            {outline.is_line ? "line"
             : is_quadrat    ? "corners"
                             : "polygon",
             std::move(points)}};
}

json areas_of(OutlineFile& file,
              const io::ReconstructionFolder& reconstruction,
              const AreaImport& how) {
    std::vector<Polygon> polygons;
    for (Outline& outline : file.outlines) {
        outline.points =
            thinned(without_repetition(outline.points, outline.is_line), outline.is_line);
        polygons.push_back(outline.points);
    }
    const GroundHeights ground(reconstruction.mesh(), polygons);
    UniqueNames names;
    json areas = json::array();
    for (const Outline& outline : file.outlines) {
        std::string name = names.take(name_of(outline, how));
        if (outline.num_holes > 0 && !how.fill_holes)
            throw Error(ErrorCode::BadData,
                        "area '" + name + "' has " + std::to_string(outline.num_holes) +
                            " holes, which cannot be measured: give --fill-holes to take its outer "
                            "outline, or cut it into areas without holes");
        areas.push_back(area_of(outline, std::move(name), ground));
        const std::string label = label_of(outline, how);
        if (!label.empty()) areas.back()["label"] = label;
    }
    return areas;
}

// Throws Error{BadData} if a point is not finite or too far away to be of this dive.
void require_near(const OutlineFile& file, const std::string& coordinates) {
    constexpr double kMaxCoordinate_m = 1e5;
    for (const Outline& outline : file.outlines)
        for (const Eigen::Vector2d& point : outline.points)
            if (!(point.cwiseAbs().maxCoeff() <= kMaxCoordinate_m))
                throw Error(ErrorCode::BadData,
                            "a point of feature " + std::to_string(outline.feature + 1) +
                                " is not finite or is beyond 100 km of this dive, if its "
                                "coordinates are " +
                                coordinates + ": check its coordinate system, or --areas-crs");
}

json document_of(OutlineFile& file,
                 const io::ReconstructionFolder& reconstruction,
                 const AreaImport& how) {
    std::erase_if(file.outlines, [](const Outline& outline) { return outline.points.empty(); });
    if (file.outlines.empty()) throw Error(ErrorCode::BadData, "it has no polygon and no line");
    require_column(file, how.name_column);
    require_column(file, how.label_column);
    override_coordinates(file, how.crs);
    const std::string coordinates = coordinates_text(file);
    place_outlines(file, reconstruction);
    require_near(file, coordinates);
    return {{"frame", "world"}, {"areas", areas_of(file, reconstruction, how)}};
}

}  // namespace

json import_areas(const std::filesystem::path& file,
                  const io::ReconstructionFolder& reconstruction,
                  const AreaImport& how) try {
    auto content = read_outlines(file, how.map);
    json document = std::holds_alternative<json>(content)
                        ? std::get<json>(std::move(content))
                        : document_of(std::get<OutlineFile>(content), reconstruction, how);
    parse_areas(document);  // throws for what cannot be measured
    return document;
} catch (const Error& error) {
    throw Error(error.code(), file.string() + ": " + error.what());
}

}  // namespace divemesh::reef
