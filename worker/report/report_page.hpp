#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "worker/report/report_measurements.hpp"

namespace divemesh::report {

// Returns report.html of an accuracy report: one self-contained page. All text from files is
// escaped; there are no scripts and no external resources.
std::string report_page(const nlohmann::json& report, const ReportMeasurements& measured);

}  // namespace divemesh::report
