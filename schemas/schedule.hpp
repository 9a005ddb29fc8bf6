#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace divemesh {

// Accuracy reports of all dives with a tag, again and again. Times are unix milliseconds.
struct Schedule {
    std::string id;
    std::string project;
    std::string cron;  // see schemas/cron.hpp
    std::string tag;
    std::string preset;                                 // of reconstructions that are missing
    nlohmann::json options = nlohmann::json::object();  // of the reports
    std::int64_t created_at_ms = 0;
    std::int64_t next_run_ms = 0;
    std::int64_t last_run_ms = 0;    // 0: never
    std::int64_t last_num_jobs = 0;  // that it made then
    std::string last_problem;        // of that run; "": none
};

}  // namespace divemesh
