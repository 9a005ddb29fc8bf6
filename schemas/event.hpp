#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace divemesh {

// An event, written in the transaction of the change it reports. `sequence` rises in commit order,
// so a watcher resumes with ?since=.
struct Event {
    std::int64_t sequence = 0;
    std::int64_t time_ms = 0;  // unix milliseconds
    std::string project;
    std::string topic;    // upload, dive, job, sensor, audit
    std::string subject;  // id of the object that it is about
    std::string type;     // upload.completed, dive.ready, job.state, sensor.alarm
    nlohmann::json data = nlohmann::json::object();
};

}  // namespace divemesh
