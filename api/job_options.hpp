#pragma once

#include <nlohmann/json_fwd.hpp>

namespace divemesh::api {

// Check the options of a report, of a comparison, and of the reports of a schedule. The dives and
// jobs they name are looked up where the job is created (storage/report_jobs.hpp). Throw
// InvalidInput that points at each unknown or wrong option.
void check_report_options(const nlohmann::json& options);
void check_compare_options(const nlohmann::json& options);
void check_scheduled_options(const nlohmann::json& options);

}  // namespace divemesh::api
