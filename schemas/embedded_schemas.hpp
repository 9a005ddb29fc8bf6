#pragma once

#include <string_view>

namespace divemesh {

// Return the texts of metrics.schema.json and report.schema.json at build time.
std::string_view metrics_schema_json();
std::string_view report_schema_json();

}  // namespace divemesh
