#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// What a status tells as a number: a column of the history. A flag is 0 or 1.
struct StatusField {
    std::string_view name;
    bool is_flag = false;
    double least = 0.0;
    double largest = 0.0;
};

// The one place where these are declared; schemas/sensor-message.schema.json and
// storage/migrations are held to it by tests.
inline constexpr std::array<StatusField, 14> kStatusFields = {{
    {"recording", true, 0.0, 1.0},
    {"num_frames", false, 0.0, 1e12},
    {"num_dropped_frames", false, 0.0, 1e12},
    {"frame_rate_hz", false, 0.0, 10'000.0},
    {"storage_free_bytes", false, 0.0, 1e18},
    {"battery", false, 0.0, 1.0},
    {"depth_m", false, -100.0, 12'000.0},
    {"temperature_c", false, -100.0, 200.0},
    {"leak", true, 0.0, 1.0},
    {"humidity", false, 0.0, 1.0},
    {"imu_rate_hz", false, 0.0, 100'000.0},
    {"link_rssi_dbm", false, -200.0, 50.0},
    {"link_bytes_per_s", false, 0.0, 1e12},
    {"clock_offset_ms", false, -1e15, 1e15},
}};

const StatusField* find_status_field(std::string_view name);  // null: there is none

// How a device is, as its LED says: go on, look at it, or stop the dive.
enum class Summary { Ok, Attention, Stop };
std::string_view to_string(Summary summary);
Summary summary_from_string(std::string_view text);

// Something that is wrong with a device. Names: SensorAlarm of api/openapi.yaml.
struct Alarm {
    std::string name;
    Summary level = Summary::Attention;
    std::string detail;  // for people: what, and what to do
    bool operator==(const Alarm&) const = default;
};

// What a status says is wrong; `before`: what was, which ends a little beyond where it began. A
// device that lights its own LED and the server that warns its team go by this alone.
std::vector<Alarm> alarms_of(const nlohmann::json& status, std::span<const Alarm> before = {});
Summary summary_of(std::span<const Alarm> alarms);

// Throws InvalidInput that names every known field which is of the wrong type or out of range, and
// where it is below `pointer`. Unknown fields are left alone: they are kept as they came.
void check_status(const nlohmann::json& status, const std::string& pointer);

// A known field as a number; nothing where the status does not tell it.
std::optional<double> status_value(const nlohmann::json& status, const StatusField& field);

void to_json(nlohmann::json& json, const Alarm& alarm);
void from_json(const nlohmann::json& json, Alarm& alarm);

}  // namespace divemesh
