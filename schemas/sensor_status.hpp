#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// A numeric field of a status: a column of the history. A flag is 0 or 1.
struct StatusField {
    std::string_view name;
    bool is_flag = false;
    double min = 0.0;
    double max = 0.0;
};

// The only place that declares these fields; tests compare schemas/sensor-report.schema.json and
// storage/migrations with it.
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

// Limits of a status's "errors".
inline constexpr std::size_t kMaxStatusErrors = 32;
inline constexpr std::size_t kMaxStatusErrorBytes = 256;

const StatusField* find_status_field(std::string_view name);  // null: unknown field

// A device's condition, as its LED shows it: continue, check it, or stop the dive.
enum class Summary { Ok, Attention, Stop };
std::string_view to_string(Summary summary);
Summary summary_from_string(std::string_view text);

// A problem of a device. Names: SensorAlarm of api/openapi.yaml.
struct Alarm {
    std::string name;
    Summary level = Summary::Attention;
    std::string detail;  // for users: what is wrong, and what to do
    bool operator==(const Alarm&) const = default;
};

// Returns the alarms of a status. `before` are the previous alarms, which end only somewhat beyond
// their limits (hysteresis). The device's own LED and the server's warnings both use only this.
std::vector<Alarm> alarms_of(const nlohmann::json& status, std::span<const Alarm> before = {});
// Returns the worst level of the alarms; Ok without alarms.
Summary summary_of(std::span<const Alarm> alarms);

// Throws InvalidInput, which names every known field of a wrong type or out of range, and its place
// below `pointer`. Unknown fields are kept as they are.
void check_status(const nlohmann::json& status, const std::string& pointer);

// Returns a known field as a number; nullopt if the status lacks it.
std::optional<double> status_value(const nlohmann::json& status, const StatusField& field);

void to_json(nlohmann::json& json, const Alarm& alarm);
void from_json(const nlohmann::json& json, Alarm& alarm);

}  // namespace divemesh
