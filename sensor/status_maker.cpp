#include "sensor/status_maker.hpp"

#include <algorithm>

#include "schemas/sensor_status.hpp"
#include "worker/dive/entry_name.hpp"

namespace divemesh::sensor {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxDiveBytes = 64;

template <typename Value>
void set(json& status, const char* name, const std::optional<Value>& value) {
    if (value) status[name] = *value;
}

// Returns a text that a status may hold: valid UTF-8, limited in length.
std::string shortened(const std::string& text, std::size_t max_num_bytes) {
    std::string clean = dive::printable(text);
    std::size_t end = std::min(clean.size(), max_num_bytes);
    while (end > 0 && end < clean.size() && (clean[end] & 0xC0) == 0x80) --end;
    return clean.substr(0, end);
}

void set_errors(const StatusParts& parts, json& status) {
    json errors = json::array();
    for (const auto* list : {&parts.errors, &parts.recording.errors})
        for (const std::string& error : *list)
            if (errors.size() < kMaxStatusErrors)
                errors.push_back(shortened(error, kMaxStatusErrorBytes));
    status["errors"] = errors;
}

void set_clock(const StatusParts& parts, json& status) {
    status["clock_quality"] = parts.is_clock_synchronised ? "synchronised" : "free";
    if (parts.link.server_time)
        status["clock_offset_ms"] =
            parts.wall_time_ms - parts.link.server_time->earliest_ms(parts.uptime_ms);
}

}  // namespace

json make_status(const StatusParts& parts) {
    const RecordingCounts& counts = parts.recording.counts;
    json status = {{"recording", parts.recording.is_recording},
                   {"dive", shortened(parts.recording.dive, kMaxDiveBytes)},
                   {"num_frames", counts.num_frames},
                   {"num_dropped_frames", counts.num_dropped_frames}};
    set(status, "frame_rate_hz", counts.frame_rate_hz);
    set(status, "imu_rate_hz", counts.imu_rate_hz);
    set(status, "orientation", counts.orientation);
    set(status, "depth_m", counts.depth_m);
    set(status, "storage_free_bytes", parts.recording.storage_free_bytes);
    set(status, "battery", parts.battery);
    set(status, "link_rssi_dbm", parts.link_rssi_dbm);
    if (parts.link.bytes_per_s > 0.0) status["link_bytes_per_s"] = parts.link.bytes_per_s;
    if (parts.images)
        status["pictures"] = {{"dark", parts.images->dark},
                              {"blurred", parts.images->blurred},
                              {"frozen", parts.images->frozen}};
    if (parts.back_in_s) status["dive_plan"] = {{"back_in_s", *parts.back_in_s}};
    if (!parts.assessment.is_null()) status["quick_look"] = parts.assessment;
    set_clock(parts, status);
    set_errors(parts, status);
    return status;
}

}  // namespace divemesh::sensor
