#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace divemesh::report {

// Returns the common templates of all pages by name: {{>page_head}} up to </head>, of `title`;
// {{>accuracy_rows}} of `accuracy` and `expected`, {{>dive_rows}} of `dive` and `result`, the four
// of them made by rows_values(); {{>rows}}, {{>grid}} and {{>findings}} of the values below. A part
// ends with a line break, so what follows it in a page stands on the line of its name.
const std::map<std::string, std::string_view>& html_parts();

using HtmlRows = std::vector<std::pair<std::string, std::string>>;  // name, value

// Returns the values for {{>rows}}, a table of names and values; null without rows.
nlohmann::json rows_values(const HtmlRows& rows);

// Returns the values for {{>grid}}, a table whose first row is its head; null without further rows.
nlohmann::json grid_values(const std::vector<std::vector<std::string>>& rows);

// Returns the verdict of metrics.json or of a report's "reconstruction" in words, as `text`, e.g.
// "Usable with restrictions: path, scale", and its `class`; null in documents of earlier versions.
nlohmann::json verdict_values(const nlohmann::json& judged);

// Returns the values for {{>findings}}, as they are in metrics.json.
nlohmann::json findings_values(const nlohmann::json& findings);

}  // namespace divemesh::report
