#include "worker/dive/dive_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "schemas/invalid_input.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/entry_name.hpp"

namespace divemesh::dive {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxTags = 64;
constexpr std::size_t kMaxNotes_bytes = 9'900;  // with an ellipsis below the limit of an edit
constexpr std::size_t kMaxImportFindings = 200;
constexpr std::size_t kMaxCode_bytes = 64;
constexpr std::size_t kMaxMessage_bytes = 1000;
constexpr std::size_t kMaxDistances = 100'000;
constexpr std::size_t kMaxMarks = 10'000;  // of one end

// Returns the object in `text`; an empty object, with a warning, if there is none.
json parse_object(std::string_view text, const std::string& file, FindingLog& findings) {
    std::string problem = "it is not a JSON object";
    try {
        json object = json::parse(text);
        if (object.is_object()) return object;
    } catch (const json::exception& error) {
        problem = printable(error.what());
    }
    findings.warning(kJsonUnreadable,
                     file,
                     file + " is ignored: " + problem,
                     "Correct it with the help of a JSON checker.");
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

// Returns `notes` with its lines, each printable, up to a length.
std::string notes_at(const json& object) {
    std::string text = text_at(object, "notes");
    std::ranges::replace(text, '\t', ' ');
    std::string notes;
    for (std::size_t begin = 0; begin < text.size() && notes.size() < kMaxNotes_bytes;) {
        const std::size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
        notes += printable(std::string_view(text).substr(begin, end - begin),
                           kMaxNotes_bytes - notes.size());
        if (end < text.size()) notes += '\n';
        begin = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    }
    return notes;
}

// Reads `water` as an object, or the values at the top level.
void read_water(const json& object, DiveInfo& info) {
    const auto found = object.find("water");
    const json& water = found != object.end() && found->is_object() ? *found : object;
    for (const char* key : {"temperature_c", "temperature", "water_temperature_c"})
        if (!info.water_temperature_c) info.water_temperature_c = number_at(water, key);
    for (const char* key : {"salinity_psu", "salinity", "water_salinity_psu"})
        if (!info.water_salinity_psu) info.water_salinity_psu = number_at(water, key);
}

// Parses {"latitude_deg": 44.6, "longitude_deg": -63.6, "x_azimuth_deg": 90}; the azimuth is
// optional. An incomplete or wrong position would move the model elsewhere, so it is left out with
// a warning.
std::optional<types::GeographicPosition> position_at(const json& object, FindingLog& findings) {
    const auto found = object.find("position");
    if (found == object.end()) return std::nullopt;
    if (found->is_object()) {
        const auto latitude_deg = number_at(*found, "latitude_deg");
        const auto longitude_deg = number_at(*found, "longitude_deg");
        const auto azimuth_deg = number_at(*found, "x_azimuth_deg");
        const types::GeographicPosition position{
            latitude_deg.value_or(0.0), longitude_deg.value_or(0.0), azimuth_deg};
        if (latitude_deg && longitude_deg && position.is_valid() &&
            (azimuth_deg || !found->contains("x_azimuth_deg")))
            return position;
    }
    findings.warning("position_unusable",
                     "dive.json",
                     "the position is ignored: it needs the numbers latitude_deg (-80 to 84) and "
                     "longitude_deg (-180 to 180), and optionally x_azimuth_deg",
                     "Write it in decimal degrees, WGS 84.");
    return std::nullopt;
}

bool is_finding_code(const std::string& code) {
    return !code.empty() && code.size() <= kMaxCode_bytes &&
           code.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

// Reports what was found when the dive was imported from a recording in another form.
void report_import(const json& object, FindingLog& findings) {
    const auto origin = object.find("imported_from");
    if (origin == object.end() || !origin->is_object()) return;
    const auto list = origin->find("findings");
    if (list == origin->end() || !list->is_array()) return;
    for (std::size_t i = 0; i < std::min(list->size(), kMaxImportFindings); ++i) {
        const json& item = (*list)[i];
        const std::string code = item.is_object() ? text_at(item, "code") : "";
        if (!is_finding_code(code)) continue;
        Finding finding{.severity = Severity::Warning,
                        .code = code,
                        .where = printable(text_at(item, "where")),
                        .message = printable(text_at(item, "message"), kMaxMessage_bytes),
                        .remedy = printable(text_at(item, "remedy"), kMaxMessage_bytes)};
        if (text_at(item, "severity") == to_string(Severity::Info))
            finding.severity = Severity::Info;
        findings.add(std::move(finding));
    }
}

template <int kSize>
std::optional<Eigen::Vector<double, kSize>> point_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_array() || found->size() != kSize) return std::nullopt;
    Eigen::Vector<double, kSize> point;
    for (int i = 0; i < kSize; ++i) {
        const json& value = (*found)[static_cast<std::size_t>(i)];
        if (!value.is_number()) return std::nullopt;
        point[i] = value.get<double>();
    }
    return point.allFinite() ? std::optional(point) : std::nullopt;
}

// Parses {"timestamp_ns": 1, "left": [u, v], "right": [u, v]}; the right point is optional.
std::optional<Mark> parse_mark(const json& item) {
    if (!item.is_object()) return std::nullopt;
    const auto timestamp_ns = item.find("timestamp_ns");
    const auto left = point_at<2>(item, "left");
    if (timestamp_ns == item.end() || !timestamp_ns->is_number_integer() || !left)
        return std::nullopt;
    if (item.contains("right") && !point_at<2>(item, "right")) return std::nullopt;
    return Mark{timestamp_ns->get<std::int64_t>(), *left, point_at<2>(item, "right")};
}

// Returns an empty list if one of the marks is invalid: without it the length would differ.
std::vector<Mark> marks_at(const json& object, const char* key) {
    std::vector<Mark> marks;
    const auto found = object.find(key);
    if (found == object.end() || !found->is_array() || found->size() > kMaxMarks) return marks;
    for (const json& item : *found) {
        const auto mark = parse_mark(item);
        if (!mark) return {};
        marks.push_back(*mark);
    }
    return marks;
}

std::optional<KnownDistance> parse_known_distance(const json& item) {
    if (!item.is_object()) return std::nullopt;
    KnownDistance known;
    known.name = text_at(item, "name");
    known.distance_m = number_at(item, "distance_m").value_or(0.0);
    known.marks_a = marks_at(item, "marks_a");
    known.marks_b = marks_at(item, "marks_b");
    const auto a = point_at<3>(item, "a");
    const auto b = point_at<3>(item, "b");
    if (known.distance_m <= 0.0 || !(known.is_marked() || (a && b))) return std::nullopt;
    known.a_world = a.value_or(Eigen::Vector3d::Zero());
    known.b_world = b.value_or(Eigen::Vector3d::Zero());
    return known;
}

}  // namespace

DiveInfo parse_dive_info(std::string_view text, FindingLog& findings) {
    const json object = parse_object(text, "dive.json", findings);
    DiveInfo info;
    info.name = printable(text_at(object, "name"));
    info.site = printable(text_at(object, "site"));
    info.rig = printable(text_at(object, "rig"));
    read_water(object, info);
    info.notes = notes_at(object);
    info.position = position_at(object, findings);
    report_import(object, findings);
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
        if (const auto known = parse_known_distance(item)) {
            distances.push_back(*known);
            continue;
        }
        findings.warning("measurement_incomplete",
                         file,
                         "the distance '" +
                             printable(item.is_object() ? text_at(item, "name") : "") +
                             "' is ignored: it needs distance_m > 0 and both ends, as a, b (three "
                             "numbers each) or as marks_a, marks_b (timestamp_ns, left, right)",
                         "Write the ends in m in the ground truth's world, or mark them in pixels "
                         "in at least four frames.");
    }
    return distances;
}

std::optional<PortYaml> parse_port(std::string_view text, FindingLog& findings) try {
    const json object = json::parse(text, nullptr, false);  // parse_dive_info() tells what is wrong
    if (!object.is_object() || !object.contains("port")) return std::nullopt;
    PortYaml port;
    for (const auto& [key, value] : object["port"].get<json::object_t>())
        if (key == "type")
            port.type = value.get<std::string>();
        else
            port.numbers[key] = value.is_array() ? value.get<std::vector<double>>()
                                                 : std::vector<double>{value.get<double>()};
    return port;
} catch (const json::exception& error) {
    findings.error("calibration_port",
                   "dive.json",
                   "the port of dive.json cannot be read: " + printable(error.what()),
                   "Write it with the keys of sensor.yaml, as a JSON object.");
    return std::nullopt;
}

std::optional<MarkerPlan> parse_markers(std::string_view text, FindingLog& findings) {
    const std::string file = "markers.json";
    const std::string remedy = "Correct it, or remove the file if you do not need the markers.";
    try {
        return marker_plan_from_json(json::parse(text));
    } catch (const json::exception& error) {
        findings.error("markers_unreadable", file, printable(error.what()), remedy);
    } catch (const InvalidInput& wrong) {
        for (const Fault& fault : wrong.faults())
            findings.error("markers_unreadable", file, printable(fault.detail), remedy);
    }
    return std::nullopt;
}

}  // namespace divemesh::dive
