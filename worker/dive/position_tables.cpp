#include "worker/dive/position_tables.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/read_samples.hpp"
#include "worker/io/geographic_frame.hpp"

namespace divemesh::dive {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxControlPoints = 10'000;
constexpr double kMaxHeight_m = 12'000.0;  // above or below the datum
constexpr double kMaxSigma_m = 10'000.0;   // of a position that says anything
constexpr double kMaxSpeed_m_s = 50.0;
constexpr double kMaxNorthing_m = 9.3e6;  // latitude 84 degrees
constexpr const char* kControlPoints = "control_points.json";
constexpr const char* kUnreadable = "position_unreadable";
constexpr const char* kSystems =
    "State 4326 (latitude, longitude) or a zone of UTM on WGS 84 (32601 to 32660, 32701 to 32760); "
    "convert coordinates of another system first.";
// A towed float drifts as far as its line lets it.
constexpr double kFloatOffset_m = 2.0;

// Returns true if a pair of coordinates can be a place of UTM.
bool is_place(const Eigen::Vector3d& stated, int epsg) {
    if (std::abs(stated.z()) > kMaxHeight_m) return false;
    if (epsg == io::kLongitudeLatitudeEpsg)
        return types::GeographicPosition{stated.x(), stated.y(), {}}.is_valid();
    return stated.x() > 0.0 && stated.x() < 1e6 && stated.y() > 0.0 && stated.y() < kMaxNorthing_m;
}

bool is_same(const types::PositionSample& a, const types::PositionSample& b) {
    return a.utm_m == b.utm_m && a.sigma_h_m == b.sigma_h_m && a.sigma_v_m == b.sigma_v_m;
}

bool is_sigma(double value) { return value > 0.0 && value <= kMaxSigma_m; }

std::optional<types::PositionKind> kind_of(std::string_view text) {
    for (const auto& [kind, name] : types::kPositionKindTexts)
        if (name == text) return kind;
    return std::nullopt;
}

double number_or(const json& object, const char* key, double otherwise) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<double>() : otherwise;
}

// Parses {"name": "A", "marker_id": 3, "position": [n, e, up], "sigma_h_m": 0.02, "sigma_v_m":
// 0.03}; returns nullopt if it is none.
std::optional<types::ControlPoint> parse_point(const json& item, int epsg) {
    if (!item.is_object()) return std::nullopt;
    types::ControlPoint point;
    const auto name = item.find("name");
    const auto id = item.find("marker_id");
    const auto place = item.find("position");
    if (name == item.end() || !name->is_string() || id == item.end() || !id->is_number_integer() ||
        place == item.end() || !place->is_array() || place->size() < 2 || place->size() > 3)
        return std::nullopt;
    for (std::size_t i = 0; i < place->size(); ++i) {
        if (!(*place)[i].is_number()) return std::nullopt;
        point.utm_m[static_cast<Eigen::Index>(i)] = (*place)[i].get<double>();
    }
    point.name = printable(name->get<std::string>());
    point.marker_id = id->get<int>();
    point.sigma_h_m = number_or(item, "sigma_h_m", 0.0);
    point.sigma_v_m = number_or(item, "sigma_v_m", 0.0);
    const bool has_height = place->size() == 3;
    if (!is_place(point.utm_m, epsg) || !is_sigma(point.sigma_h_m) || point.marker_id < 0 ||
        has_height != is_sigma(point.sigma_v_m))
        return std::nullopt;
    return point;
}

// Converts places from a coordinate system to the common one, which the first of all decides.
void convert(const std::vector<Eigen::Vector3d*>& places,
             int epsg,
             const std::string& file,
             types::OutsidePositions& outside,
             FindingLog& findings) {
    if (places.empty()) return;
    const bool is_angle = epsg == io::kLongitudeLatitudeEpsg;
    std::vector<Eigen::Vector2d> given;
    given.reserve(places.size());
    for (const Eigen::Vector3d* place : places)
        given.emplace_back(is_angle ? Eigen::Vector2d(place->y(), place->x())
                                    : Eigen::Vector2d(place->head<2>()));
    if (outside.utm_epsg == 0)
        outside.utm_epsg =
            is_angle ? io::utm_frame({given[0].y(), given[0].x(), std::nullopt}).epsg : epsg;
    try {
        const auto projected = io::to_utm(given, epsg, outside.utm_epsg);
        for (std::size_t i = 0; i < places.size(); ++i) places[i]->head<2>() = projected[i];
    } catch (const Error& error) {
        findings.error(
            kUnreadable,
            file,
            "its places are far from those of the other files: " + std::string(error.what()),
            "Check the coordinate system (epsg) of each file.");
    }
}

}  // namespace

std::optional<int> position_system(const std::optional<double>& epsg,
                                   const std::string& file,
                                   FindingLog& findings) {
    if (!epsg) {
        findings.error(
            kUnreadable, file, file + " does not state the coordinate system (epsg)", kSystems);
        return std::nullopt;
    }
    const int code = std::abs(*epsg) < 1e6 ? static_cast<int>(*epsg) : 0;
    if (code == *epsg && io::is_wgs84(code)) return code;
    findings.error(
        kUnreadable,
        file,
        "the coordinate system EPSG:" + base::significant(*epsg, 9) + " is not supported",
        kSystems);
    return std::nullopt;
}

std::vector<types::PositionSample> parse_positions(std::string_view text,
                                                   int epsg,
                                                   const std::string& file,
                                                   FindingLog& findings,
                                                   CommonClock* clock) {
    StampCheck check("position", file, findings);
    return read_samples<5, types::PositionSample>(
        text,
        check,
        clock,
        [epsg](std::int64_t timestamp_ns, const auto& v) -> std::optional<types::PositionSample> {
            const types::PositionSample sample{timestamp_ns, {v[0], v[1], v[2]}, v[3], v[4]};
            const bool has_height = sample.sigma_v_m != 0.0;
            if (!is_place(sample.utm_m, epsg) || !is_sigma(sample.sigma_h_m) ||
                (has_height && !is_sigma(sample.sigma_v_m)))
                return std::nullopt;
            return sample;
        },
        is_same);
}

std::vector<types::VelocitySample> parse_velocities(std::string_view text,
                                                    const std::string& file,
                                                    FindingLog& findings,
                                                    CommonClock* clock) {
    StampCheck check("velocity", file, findings);
    return read_samples<4, types::VelocitySample>(
        text,
        check,
        clock,
        [](std::int64_t timestamp_ns, const auto& v) -> std::optional<types::VelocitySample> {
            const types::VelocitySample sample{timestamp_ns, {v[0], v[1], v[2]}, v[3]};
            if (sample.velocity_instrument.norm() > kMaxSpeed_m_s ||
                !(sample.sigma_m_s > 0.0 && sample.sigma_m_s <= kMaxSpeed_m_s))
                return std::nullopt;
            return sample;
        },
        [](const types::VelocitySample& a, const types::VelocitySample& b) {
            return a.velocity_instrument == b.velocity_instrument && a.sigma_m_s == b.sigma_m_s;
        });
}

std::optional<types::PositionSource> describe_source(const std::string& name,
                                                     const SensorYaml& yaml,
                                                     const std::string& file,
                                                     FindingLog& findings) {
    types::PositionSource source;
    source.name = name;
    const auto kind = kind_of(yaml.position_kind);
    if (!kind) {
        findings.error(kUnreadable,
                       file,
                       file + " does not state what measured the positions (kind)",
                       "State kind: gps_float, usbl or surface_fix.");
        return std::nullopt;
    }
    source.kind = *kind;
    const auto epsg = position_system(yaml.epsg, file, findings);
    if (!epsg) return std::nullopt;
    source.epsg = *epsg;
    source.offset_sigma_m =
        yaml.offset_sigma_m.value_or(*kind == types::PositionKind::GpsFloat ? kFloatOffset_m : 0.0);
    if (source.offset_sigma_m >= 0.0 && source.offset_sigma_m <= kMaxSigma_m) return source;
    findings.error(kUnreadable,
                   file,
                   "offset_sigma_m is " + base::significant(source.offset_sigma_m),
                   "State the standard deviation in m of the offset that all positions share, or "
                   "leave it out.");
    return std::nullopt;
}

void parse_control_points(std::string_view text,
                          types::OutsidePositions& outside,
                          FindingLog& findings) {
    const std::string remedy =
        "Write {\"epsg\": 32620, \"points\": [{\"name\": \"A\", \"marker_id\": 3, \"position\": "
        "[easting, northing, up], \"sigma_h_m\": 0.02, \"sigma_v_m\": 0.03}]}; with epsg 4326 the "
        "position is [latitude, longitude, up]. Leave up and sigma_v_m out where it is not known.";
    const auto refuse = [&](const std::string& where, const std::string& problem) {
        findings.error("control_points_unreadable", where, problem, remedy);
    };
    json object;
    try {
        object = json::parse(text);
    } catch (const json::exception& error) {
        return refuse(kControlPoints, printable(error.what()));
    }
    const auto list = object.is_object() ? object.find("points") : object.end();
    if (!object.is_object() || list == object.end() || !list->is_array())
        return refuse(kControlPoints, "there is no list \"points\"");
    if (list->size() > kMaxControlPoints)
        return refuse(kControlPoints,
                      "it has " + std::to_string(list->size()) + " points, more than the " +
                          std::to_string(kMaxControlPoints) + " allowed");
    const auto stated = object.find("epsg");
    const auto epsg = position_system(stated != object.end() && stated->is_number()
                                          ? std::optional(stated->get<double>())
                                          : std::nullopt,
                                      kControlPoints,
                                      findings);
    if (!epsg) return;
    std::set<int> ids;
    for (std::size_t i = 0; i < list->size(); ++i) {
        const auto point = parse_point((*list)[i], *epsg);
        const std::string where = std::string(kControlPoints) + "#/points/" + std::to_string(i);
        if (!point)
            refuse(where, "this is no control point");
        else if (!ids.insert(point->marker_id).second)
            refuse(where, "marker " + std::to_string(point->marker_id) + " has two positions");
        else
            outside.control_points.push_back(*point);
    }
    outside.control_points_epsg = *epsg;
}

void to_common_system(types::OutsidePositions& outside, FindingLog& findings) {
    for (types::PositionSource& source : outside.sources) {
        std::vector<Eigen::Vector3d*> places;
        for (types::PositionSample& sample : source.samples) places.push_back(&sample.utm_m);
        convert(places, source.epsg, "mav0/" + source.name + "/data.csv", outside, findings);
    }
    std::vector<Eigen::Vector3d*> places;
    for (types::ControlPoint& point : outside.control_points) places.push_back(&point.utm_m);
    convert(places, outside.control_points_epsg, kControlPoints, outside, findings);
}

}  // namespace divemesh::dive
