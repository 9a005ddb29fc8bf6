#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sensor/link/link.hpp"
#include "sensor/preview/image_check.hpp"
#include "sensor/recording/recording_source.hpp"

namespace divemesh::sensor {

// The parts of a status; unknown ones are left out.
struct StatusParts {
    RecordingState recording;
    std::optional<ImageCheck::Shares> images;
    LinkState link;
    std::optional<double> battery;  // 0 to 1
    std::optional<double> link_rssi_dbm;
    bool is_clock_synchronised = false;
    std::int64_t uptime_ms = 0;
    std::int64_t wall_time_ms = 0;
    std::optional<double> back_in_s;  // from the dive plan
    nlohmann::json assessment;        // null: no dive assessment
    std::vector<std::string> errors;  // besides those of the recording
};

// Returns a status as in schemas/sensor-report.schema.json, with the assessment under "quick_look".
nlohmann::json make_status(const StatusParts& parts);

}  // namespace divemesh::sensor
