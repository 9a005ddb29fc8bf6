#pragma once

#include <nlohmann/json_fwd.hpp>

namespace divemesh::api {

// What may be asked of a report, of a comparison, and of the reports of a schedule. What they name
// is looked up where the job is made (storage/report_jobs.hpp). Throw InvalidInput that points at
// each option that is unknown or wrong.
void check_report_options(const nlohmann::json& options);
void check_compare_options(const nlohmann::json& options);
void check_scheduled_options(const nlohmann::json& options);

}  // namespace divemesh::api
