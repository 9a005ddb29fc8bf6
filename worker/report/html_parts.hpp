#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace divemesh::report {

// What the pages for a person have in common, as templates by name: {{>page_head}} up to </head>,
// of `title`; {{>rows}}, {{>grid}} and {{>findings}} of the values below.
const std::map<std::string, std::string_view>& html_parts();

using HtmlRows = std::vector<std::pair<std::string, std::string>>;  // name, value

// For {{>rows}}, a table of names and values; null when there is no row.
nlohmann::json rows_values(const HtmlRows& rows);

// For {{>grid}}, a table whose first row is its head; null when there is no other.
nlohmann::json grid_values(const std::vector<std::vector<std::string>>& rows);

// For {{>findings}}, as they are in metrics.json.
nlohmann::json findings_values(const nlohmann::json& findings);

}  // namespace divemesh::report
