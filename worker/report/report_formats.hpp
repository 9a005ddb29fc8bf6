#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace divemesh::report {

// Returns the metrics of report.json as RFC 4180, a row each: figure, value, unit, method,
// alignment. A text that a spreadsheet would take for a formula gets an apostrophe in front.
std::string report_csv(const nlohmann::json& report);

// Returns the requirements of report.json as JUnit XML for build servers (the layout that Jenkins,
// GitLab and Surefire read): one test case each, a failure with its reason if it is not met. The
// verdict on the reconstruction is among the properties, the findings are the output.
std::string report_junit(const nlohmann::json& report);

}  // namespace divemesh::report
