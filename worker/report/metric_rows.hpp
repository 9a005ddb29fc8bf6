#pragma once

#include <nlohmann/json.hpp>

#include "worker/report/html_parts.hpp"

namespace divemesh::report {

// Figures of metrics.json in the words and units of a person; what is not there is left out.
HtmlRows accuracy_rows(const nlohmann::json& metrics);
HtmlRows expected_rows(const nlohmann::json& metrics);  // what the result expects of itself
HtmlRows dive_rows(const nlohmann::json& metrics);
HtmlRows result_rows(const nlohmann::json& metrics);

}  // namespace divemesh::report
