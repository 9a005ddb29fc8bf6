#pragma once

#include <string_view>

namespace divemesh {

// The texts of metrics.schema.json and report.schema.json as they were when the program was built.
std::string_view metrics_schema_json();
std::string_view report_schema_json();

}  // namespace divemesh
