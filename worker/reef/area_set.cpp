#include "worker/reef/area_set.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <set>

#include "schemas/error.hpp"
#include "worker/reef/area_plane.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

constexpr std::uintmax_t kMaxFile_bytes = 64U << 20U;
constexpr std::size_t kMaxAreas = 10'000;
constexpr std::size_t kMaxNameLength = 200;
constexpr double kMaxCoordinate_m = 1e5;
constexpr double kMaxTransect_m = 1e4;  // per transect, which is sampled every 5 mm

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
    throw Error(ErrorCode::BadData, where + ": " + what);
}

Eigen::Vector3d read_vector(const json& value, const std::string& where) {
    Eigen::Vector3d vector;
    if (!value.is_array() || value.size() != 3) refuse(where, "a point is not [x, y, z]");
    for (int i = 0; i < 3; ++i) {
        if (!value[i].is_number()) refuse(where, "a coordinate is not a number");
        vector[i] = value[i].get<double>();
        if (!(std::abs(vector[i]) <= kMaxCoordinate_m))
            refuse(where, "a coordinate is not finite or is beyond 100 km");
    }
    return vector;
}

std::string read_text(const json& entry, const char* key, const std::string& where) {
    const auto found = entry.find(key);
    if (found == entry.end()) return "";
    if (!found->is_string()) refuse(where, std::string(key) + " is not text");
    auto text = found->get<std::string>();
    if (text.size() > kMaxNameLength)
        refuse(where, std::string(key) + " is longer than " + std::to_string(kMaxNameLength));
    for (const char c : text)
        if (static_cast<unsigned char>(c) < 0x20U || c == 0x7f)
            refuse(where, std::string(key) + " contains a control character");
    return text;
}

AreaKind read_kind(const json& entry, const std::string& where) {
    const std::string text = read_text(entry, "kind", where);
    if (text.empty()) return entry.contains("corners") ? AreaKind::Quadrat : AreaKind::Outline;
    for (const AreaKind kind : {AreaKind::Quadrat, AreaKind::Outline, AreaKind::Transect})
        if (text == to_string(kind)) return kind;
    refuse(where, "kind must be quadrat, polygon or transect, not '" + text + "'");
}

std::vector<Eigen::Vector3d> read_points(const json& entry, const std::string& where) {
    const json* list = nullptr;
    for (const char* key : {"corners", "polygon", "line"}) {
        const auto found = entry.find(key);
        if (found == entry.end()) continue;
        if (list != nullptr)
            refuse(where, "there is more than one of corners, polygon and line: give exactly one");
        list = &*found;
    }
    if (list == nullptr || !list->is_array())
        refuse(where, "there is no list corners, polygon or line");
    if (list->size() > kMaxAreaPoints)
        refuse(where, "it has more than " + std::to_string(kMaxAreaPoints) + " points");
    std::vector<Eigen::Vector3d> points;
    for (const json& point : *list) points.push_back(read_vector(point, where));
    return points;
}

void check_line(const Area& area, const std::string& where) {
    if (area.points.size() < 2) refuse(where, "a transect needs at least two points");
    const Eigen::Vector3d normal = area.normal.value_or(Eigen::Vector3d::UnitZ());
    double length_m = 0.0;
    for (std::size_t i = 1; i < area.points.size(); ++i) {
        length_m += (area.points[i] - area.points[i - 1]).norm();
        if (!((area.points[i] - area.points[i - 1]).cross(normal).norm() > 1e-4))
            refuse(where, "two points of the transect are above each other");
    }
    if (length_m > kMaxTransect_m) refuse(where, "the transect is longer than 10 km");
}

Area read_area(const json& entry, std::size_t index) {
    std::string where = "area " + std::to_string(index + 1);
    if (!entry.is_object()) refuse(where, "it must be an object");
    Area area;
    area.name = read_text(entry, "name", where);
    if (area.name.empty()) refuse(where, "it has no name");
    where = "area '" + area.name + "'";
    area.label = read_text(entry, "label", where);
    area.kind = read_kind(entry, where);
    area.points = read_points(entry, where);
    if (entry.contains("normal")) {
        const Eigen::Vector3d normal = read_vector(entry["normal"], where);
        if (!(normal.norm() > 1e-6)) refuse(where, "the normal has no length");
        area.normal = normal.normalized();
    }
    if (area.kind == AreaKind::Transect) {
        check_line(area, where);
    } else {
        if (area.points.size() < 3) refuse(where, "it needs at least three points");
        plane_of(area);
    }
    return area;
}

AreaFrame read_frame(const json& document) {
    const std::string text = read_text(document, "frame", "areas");
    if (text.empty() || text == "world") return AreaFrame::World;
    if (text == "ground_truth") return AreaFrame::GroundTruth;
    refuse("areas", "frame must be world or ground_truth, not '" + text + "'");
}

}  // namespace

std::string_view to_string(AreaKind kind) {
    constexpr std::array<std::string_view, 3> kWords = {"quadrat", "polygon", "transect"};
    return kWords[static_cast<std::size_t>(kind)];
}

AreaSet parse_areas(const json& document) {
    const auto list = document.is_object() ? document.find("areas") : document.end();
    if (list == document.end() || !list->is_array())
        refuse("areas", "the file must be an object with a list 'areas'");
    if (list->size() > kMaxAreas)
        refuse("areas", "there are more than " + std::to_string(kMaxAreas) + " areas");
    AreaSet set;
    set.frame = read_frame(document);
    std::set<std::string> names;
    for (std::size_t i = 0; i < list->size(); ++i) {
        set.areas.push_back(read_area((*list)[i], i));
        if (!names.insert(set.areas.back().name).second)
            refuse("area '" + set.areas.back().name + "'", "the name is used twice");
    }
    return set;
}

AreaSet read_areas(const std::filesystem::path& file) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    std::ifstream stream(file);
    if (error || !stream)
        throw Error(ErrorCode::NotFound, "cannot read the areas in " + file.string());
    if (size > kMaxFile_bytes) refuse(file.string(), "it is larger than 64 MiB");
    const json document = json::parse(stream, nullptr, false);
    if (document.is_discarded()) refuse(file.string(), "it is not JSON");
    try {
        return parse_areas(document);
    } catch (const Error& refused) {
        throw Error(refused.code(), file.string() + ": " + refused.what());
    }
}

AreaSet moved(AreaSet set, const Eigen::Isometry3d& T_world_frame) {
    set.frame = AreaFrame::World;
    for (Area& area : set.areas) {
        // Its metrics stay along the up direction of its own frame.
        if (!area.normal && area.kind == AreaKind::Transect)
            area.normal = T_world_frame.linear() * Eigen::Vector3d::UnitZ();
        else if (area.normal)
            area.normal = T_world_frame.linear() * *area.normal;
        for (Eigen::Vector3d& point : area.points) point = T_world_frame * point;
    }
    return set;
}

}  // namespace divemesh::reef
