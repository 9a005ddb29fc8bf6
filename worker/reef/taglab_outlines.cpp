#include "worker/reef/taglab_outlines.hpp"

#include <charconv>
#include <cmath>

#include "schemas/error.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::BadData, what); }

std::string text_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || found->is_null()) return "";
    return found->is_string() ? found->get<std::string>() : found->dump();
}

// Returns a number that may be written as text; 0 where there is none.
double number_of(const std::string& text) {
    double value = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return std::isfinite(value) ? value : 0.0;
}

// A contour as text holds the steps from point to point in tenths of a pixel: "x y dx dy dx dy".
Polygon points_of_text(const std::string& text, const std::string& where) {
    constexpr double kUnit_px = 0.1;
    Polygon points;
    std::int64_t at[2] = {0, 0};
    const char* next = text.data();
    const char* const end = text.data() + text.size();
    for (int axis = 0; next != end; axis = 1 - axis) {
        int step = 0;
        const auto read = std::from_chars(next, end, step);
        if (read.ec != std::errc()) refuse(where + "its contour is not a list of whole numbers");
        at[axis] += step;
        if (axis == 1)
            points.emplace_back(kUnit_px * static_cast<double>(at[0]),
                                kUnit_px * static_cast<double>(at[1]));
        next = read.ptr;
        while (next != end && *next == ' ') ++next;
        if (next == end && axis == 0) refuse(where + "its contour ends in the middle of a point");
    }
    return points;
}

// A contour as a list has points, in projects of before 2021.
Polygon points_of_list(const json& list, const std::string& where) {
    Polygon points;
    for (const json& point : list) {
        if (!point.is_array() || point.size() != 2 || !point[0].is_number() ||
            !point[1].is_number())
            refuse(where + "a point of its contour is not [x, y]");
        points.emplace_back(point[0].get<double>(), point[1].get<double>());
    }
    return points;
}

Outline outline_of(const json& region, std::size_t index) {
    Outline outline;
    outline.feature = index;
    if (!region.is_object()) refuse("region " + std::to_string(index + 1) + " is not an object");
    outline.columns["name"] = text_at(region, "blob name");
    outline.columns["id"] = text_at(region, "id");
    outline.columns["note"] = text_at(region, "note");
    const std::string label = text_at(region, "class name");
    outline.columns["label"] = label == "Empty" ? "" : label;  // TagLab's word for no class
    const std::string where = "region '" + outline.columns["name"] + "': ";
    const auto contour = region.find("contour");
    if (contour == region.end()) refuse(where + "it has no contour");
    outline.points = contour->is_string() ? points_of_text(contour->get<std::string>(), where)
                                          : points_of_list(*contour, where);
    const auto holes = region.find("inner contours");
    if (holes != region.end() && holes->is_array())
        outline.num_holes = static_cast<int>(holes->size());
    return outline;
}

// Adds the working area of a project, which is stored as [top, left, width, height] in pixels
// counted from the image's corner.
void add_working_area(const json& project, OutlineFile& file) {
    const auto area = project.find("working_area");
    if (area == project.end() || !area->is_array() || area->size() != 4) return;
    for (const json& value : *area)
        if (!value.is_number()) refuse("the working area is not four numbers");
    const double top = (*area)[0].get<double>() - 0.5;
    const double left = (*area)[1].get<double>() - 0.5;
    const double right = left + (*area)[2].get<double>();
    const double bottom = top + (*area)[3].get<double>();
    Outline outline;
    outline.feature = file.outlines.size();
    outline.columns = {{"name", "working area"}, {"kind", "quadrat"}};
    outline.points = {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
    file.outlines.push_back(std::move(outline));
}

const json& chosen_map(const json& project, const std::string& map) {
    const json& maps = project.at("images");
    if (!maps.is_array() || maps.empty()) refuse("the project has no map");
    std::string names;
    for (const json& one : maps) {
        if (!one.is_object()) refuse("a map of the project is not an object");
        if (map.empty() ? maps.size() == 1
                        : text_at(one, "name") == map || text_at(one, "id") == map)
            return one;
        names.append(names.empty() ? "'" : "', '").append(text_at(one, "name"));
    }
    throw Error(ErrorCode::InvalidArgument,
                (map.empty() ? "the project has several maps" : "no map is called '" + map + "'") +
                    ": name the one that is the mosaic of this reconstruction, of " + names + "'");
}

}  // namespace

OutlineFile taglab_outlines(const json& project, const std::string& map) {
    const json& image = chosen_map(project, map);
    OutlineFile file;
    file.coordinates = OutlineCoordinates::Pixels;
    file.image_size_px = {number_of(text_at(image, "width")), number_of(text_at(image, "height"))};
    // 1 is the value that TagLab starts with.
    const double pixel_mm = number_of(text_at(image, "map_px_to_mm_factor"));
    file.pixel_m = pixel_mm == 1.0 ? 0.0 : 1e-3 * pixel_mm;
    const auto annotations = image.find("annotations");
    const bool is_list = annotations != image.end() && annotations->is_array();
    if (!is_list && !image.contains(json::json_pointer("/annotations/regions")))
        refuse("the map has no annotations");
    const json& regions = is_list ? *annotations : annotations->at("regions");
    std::size_t num_points = 0;
    for (const json& region : regions) {
        file.outlines.push_back(outline_of(region, file.outlines.size()));
        num_points += file.outlines.back().points.size();
        if (num_points > kMaxOutlinePoints) refuse("the map has more than 5,000,000 points");
    }
    add_working_area(project, file);
    return file;
}

}  // namespace divemesh::reef
