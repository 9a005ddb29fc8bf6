#pragma once

#include <nlohmann/json.hpp>

#include "worker/report/html_parts.hpp"

namespace divemesh::report {

// Return metrics of metrics.json in readable words and units; missing metrics are left out.
HtmlRows accuracy_rows(const nlohmann::json& metrics);
HtmlRows expected_rows(const nlohmann::json& metrics);  // the result's own uncertainty
HtmlRows dive_rows(const nlohmann::json& metrics);
HtmlRows result_rows(const nlohmann::json& metrics);

}  // namespace divemesh::report
