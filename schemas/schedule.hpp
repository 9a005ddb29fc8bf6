#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace divemesh {

// Recurring accuracy reports of all dives with a tag. Times are unix milliseconds.
struct Schedule {
    std::string id;
    std::string project;
    std::string cron;  // see schemas/cron.hpp
    std::string tag;
    std::string preset;                                 // of missing reconstructions
    nlohmann::json options = nlohmann::json::object();  // of the reports
    std::int64_t created_at_ms = 0;
    std::int64_t next_run_ms = 0;
    std::int64_t last_run_ms = 0;    // 0: never
    std::int64_t last_num_jobs = 0;  // created by that run
    std::string last_problem;        // of that run; "": no problem
};

}  // namespace divemesh
