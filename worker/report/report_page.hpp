#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "worker/report/report_measurements.hpp"

namespace divemesh::report {

// report.html of an accuracy report: one self-contained page for a person. Whatever came from
// files is escaped, no script, nothing is loaded.
std::string report_page(const nlohmann::json& report, const ReportMeasurements& measured);

}  // namespace divemesh::report
