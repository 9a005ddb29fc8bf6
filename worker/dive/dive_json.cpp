#include "worker/dive/dive_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "worker/dive/entry_name.hpp"
#include "worker/dive/text.hpp"

namespace divemesh::worker {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxTags = 64;
constexpr std::size_t kMaxDistances = 100'000;

// The object in `text`; an empty one, and a warning, when there is none.
json parse_object(std::string_view text, const std::string& file, FindingLog& findings) {
    std::string problem = "it is no JSON object";
    try {
        json object = json::parse(text);
        if (object.is_object()) return object;
    } catch (const json::exception& error) {
        problem = printable(error.what());
    }
    findings.warning("json_unreadable",
                     file,
                     file + " is left out: " + problem,
                     "Check it with a JSON checker.");
    return json::object();
}

std::string text_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_string()) return "";
    return found->get<std::string>();
}

std::optional<double> number_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number()) return std::nullopt;
    const double value = found->get<double>();
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// `water` as an object, or the figures at the top.
void read_water(const json& object, DiveInfo& info) {
    const auto found = object.find("water");
    const json& water = found != object.end() && found->is_object() ? *found : object;
    for (const char* key : {"temperature_c", "temperature", "water_temperature_c"})
        if (!info.water_temperature_c) info.water_temperature_c = number_at(water, key);
    for (const char* key : {"salinity_psu", "salinity", "water_salinity_psu"})
        if (!info.water_salinity_psu) info.water_salinity_psu = number_at(water, key);
}

std::optional<Eigen::Vector3d> point_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_array() || found->size() != 3) return std::nullopt;
    Eigen::Vector3d point;
    for (int i = 0; i < 3; ++i) {
        const json& value = (*found)[static_cast<std::size_t>(i)];
        if (!value.is_number()) return std::nullopt;
        point[i] = value.get<double>();
    }
    return point.allFinite() ? std::optional(point) : std::nullopt;
}

}  // namespace

DiveInfo parse_dive_info(std::string_view text, FindingLog& findings) {
    const json object = parse_object(text, "dive.json", findings);
    DiveInfo info;
    info.name = printable(text_at(object, "name"));
    info.site = printable(text_at(object, "site"));
    info.rig = printable(text_at(object, "rig"));
    info.notes = text_at(object, "notes");
    read_water(object, info);
    const auto tags = object.find("tags");
    if (tags != object.end() && tags->is_array())
        for (const json& tag : *tags)
            if (tag.is_string() && info.tags.size() < kMaxTags)
                info.tags.push_back(printable(tag.get<std::string>()));
    return info;
}

std::vector<KnownDistance> parse_known_distances(std::string_view text, FindingLog& findings) {
    const std::string file = "measurements.json";
    const json object = parse_object(text, file, findings);
    std::vector<KnownDistance> distances;
    const auto list = object.find("distances");
    if (list == object.end() || !list->is_array()) return distances;
    for (const json& item : *list) {
        if (distances.size() == kMaxDistances) break;
        const std::string name = item.is_object() ? text_at(item, "name") : "";
        const auto a = item.is_object() ? point_at(item, "a") : std::nullopt;
        const auto b = item.is_object() ? point_at(item, "b") : std::nullopt;
        const double distance_m =
            item.is_object() ? number_at(item, "distance_m").value_or(0.0) : 0.0;
        if (a && b && distance_m > 0.0) {
            distances.push_back({name, *a, *b, distance_m});
            continue;
        }
        findings.warning("measurement_incomplete",
                         file,
                         "the distance '" + printable(name) +
                             "' is left out: it needs a, b (three numbers each) and distance_m > 0",
                         "Write the ends in the ground truth's world, in m.");
    }
    return distances;
}

}  // namespace divemesh::worker
