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

// Where a device is, as far as its silence tells. The only place where that is declared.
//
//   online     heard of within kSensorSilence_ms
//   submerged  silent, and expected back later
//   overdue    silent, and was expected back within the last kSensorLost_ms
//   lost       silent, and was expected back before that
//   idle       silent, and announced no dive: switched off
enum class SensorState { Online, Idle, Submerged, Overdue, Lost };
std::string_view to_string(SensorState state);
SensorState sensor_state_from_string(std::string_view text);

inline constexpr std::int64_t kSensorSilence_ms = 15'000;
inline constexpr std::int64_t kSensorLost_ms = 3'600'000;

// `back_at_ms` 0: no dive was announced.
SensorState sensor_state(std::int64_t seen_at_ms, std::int64_t back_at_ms, std::int64_t now_ms);

// A picture that a device sent, without its bytes.
struct Preview {
    std::int64_t id = 0;
    std::string camera;
    std::int64_t time_ms = 0;
    int width = 0;
    int height = 0;
    std::int64_t num_bytes = 0;
    std::string sha256;                               // of the JPEG
    nlohmann::json about = nlohmann::json::object();  // what the device told of it
};

// A device as the catalog knows it. Times are unix milliseconds of the catalog's clock.
struct Sensor {
    std::string id;
    std::string project;
    SensorState state = SensorState::Idle;
    Summary summary = Summary::Ok;  // of its alarms
    std::vector<Alarm> alarms;
    std::string boot_id;  // of which is told here
    nlohmann::json hello = nlohmann::json::object();
    nlohmann::json status = nlohmann::json::object();  // the newest that was not historical
    std::int64_t status_at_ms = 0;                     // 0: there was none
    std::int64_t status_age_ms = 0;                    // now
    bool stale = true;                                 // older than kSensorSilence_ms
    std::map<std::string, Preview> previews;           // by camera, the newest not historical
    std::int64_t seen_at_ms = 0;                       // any message
    std::int64_t back_at_ms = 0;                       // when it is expected; 0: no dive announced
    SequenceRanges received;                           // of this boot
    std::int64_t created_at_ms = 0;
};

// The sensor as it is at `now_ms`: state, age and staleness; its alarms are as they were.
Sensor as_of(Sensor sensor, std::int64_t now_ms);

// Its newest word: the status, with what a later preview tells of the pictures.
nlohmann::json newest_word(const Sensor& sensor);

// The gaps that are told: the first 32.
std::vector<SequenceRange> first_gaps(const SequenceRanges& received);

// What a device is told about a report.
struct SensorAnswer {
    std::string boot_id;
    std::int64_t acknowledged = -1;   // it and all before it need not be kept any more
    std::vector<SequenceRange> gaps;  // that are missing after that, the first ones
    std::int64_t num_lost = 0;
    int num_new = 0;
    int num_repeated = 0;
    bool superseded = false;   // another device, or a later boot, speaks for this id
    std::int64_t time_ms = 0;  // now
};

// A stretch of the history in even steps of time; steps without a status are left out.
struct SensorHistory {
    // Of one field in one step: thinning hides no peak.
    struct Value {
        double least = 0.0;
        double mean = 0.0;
        double largest = 0.0;
    };
    struct Step {
        std::int64_t time_ms = 0;  // its begin
        std::int64_t num_statuses = 0;
        std::vector<std::optional<Value>> values;  // of each field; nothing: no status told it
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
// By column: what plots and tables take, in a third of the bytes.
void to_json(nlohmann::json& json, const SensorHistory& history);

}  // namespace divemesh
