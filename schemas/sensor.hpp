#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/sensor_status.hpp"
#include "schemas/sequence_ranges.hpp"

namespace divemesh {

// The state of a device, derived from when it was last heard of. Only declared here.
//
//   online     heard of within the last kSensorSilence_ms
//   submerged  silent, and expected back later
//   overdue    silent, and was expected back within the last kSensorLost_ms
//   lost       silent, and was expected back before that
//   idle       silent, and announced no dive: assumed to be switched off
enum class SensorState { Online, Idle, Submerged, Overdue, Lost };
std::string_view to_string(SensorState state);
SensorState sensor_state_from_string(std::string_view text);

inline constexpr std::int64_t kSensorSilence_ms = 15'000;
inline constexpr std::int64_t kSensorLost_ms = 3'600'000;

// `back_at_ms` 0: no dive was announced.
SensorState sensor_state(std::int64_t seen_at_ms, std::int64_t back_at_ms, std::int64_t now_ms);

// An image that a device sent, without its bytes.
struct Preview {
    std::int64_t id = 0;
    std::string camera;
    std::int64_t time_ms = 0;
    int width = 0;
    int height = 0;
    std::int64_t num_bytes = 0;
    std::string sha256;                               // of the JPEG
    nlohmann::json about = nlohmann::json::object();  // as the device reported
};

// A device as the catalog stores it. Times are unix milliseconds of the catalog's clock.
struct Sensor {
    std::string id;
    std::string project;
    SensorState state = SensorState::Idle;
    Summary summary = Summary::Ok;  // of the alarms
    std::vector<Alarm> alarms;
    std::string boot_id;  // the boot that this describes
    nlohmann::json hello = nlohmann::json::object();
    nlohmann::json status = nlohmann::json::object();  // the newest that is not historical
    std::int64_t status_at_ms = 0;                     // 0: no status yet
    std::int64_t status_age_ms = 0;                    // at the time of reading
    bool stale = true;                                 // older than kSensorSilence_ms
    std::map<std::string, Preview> previews;           // by camera, the newest not historical
    std::int64_t seen_at_ms = 0;                       // of any message
    std::int64_t back_at_ms = 0;                       // expected; 0: no dive was announced
    SequenceRanges received;                           // of this boot
    std::int64_t created_at_ms = 0;
};

// Returns the sensor as it is at `now_ms`: updates state, age and staleness, but not its alarms.
Sensor as_of(Sensor sensor, std::int64_t now_ms);

// Returns its newest status, with what a later preview reports about the images.
nlohmann::json newest_word(const Sensor& sensor);

// Returns the first 32 gaps, which are reported to the device.
std::vector<SequenceRange> first_gaps(const SequenceRanges& received);

// The answer to a device's report.
struct SensorAnswer {
    std::string boot_id;
    std::int64_t acknowledged = -1;   // the device may drop it and all earlier messages
    std::vector<SequenceRange> gaps;  // the first missing messages after it
    std::int64_t num_lost = 0;
    int num_new = 0;
    int num_repeated = 0;
    bool superseded = false;   // another device, or a later boot, uses this id
    std::int64_t time_ms = 0;  // now
};

// A range of the history in equal steps of time, without steps that have no status.
struct SensorHistory {
    // One field in one step. Keeps min and max, so that thinning hides no peak.
    struct Value {
        double min = 0.0;
        double mean = 0.0;
        double max = 0.0;
    };
    struct Step {
        std::int64_t time_ms = 0;  // of its beginning
        std::int64_t num_statuses = 0;
        std::vector<std::optional<Value>> values;  // of each field; nullopt: in no status
    };

    std::int64_t from_ms = 0;
    std::int64_t to_ms = 0;
    std::int64_t step_ms = 0;
    std::vector<std::string> fields;
    std::vector<Step> steps;
};

void to_json(nlohmann::json& json, const Preview& preview);
void from_json(const nlohmann::json& json, Preview& preview);
void to_json(nlohmann::json& json, const Sensor& sensor);
void to_json(nlohmann::json& json, const SensorAnswer& answer);
// Writes one array per column, as plots and tables need it, in a third of the bytes.
void to_json(nlohmann::json& json, const SensorHistory& history);

}  // namespace divemesh
