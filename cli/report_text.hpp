#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace divemesh::cli {

// Returns the verdict on the reconstruction, the requirements and regressions, then the metrics
// that papers quote, of report.json.
std::string report_summary(const nlohmann::json& report);

// Returns the findings on the reconstruction, then those on its accuracy.
std::string report_findings(const nlohmann::json& report);

}  // namespace divemesh::cli
