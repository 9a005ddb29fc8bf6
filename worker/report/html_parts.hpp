#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace divemesh::worker {

// What pages for a person are put together from. All texts are escaped.
using HtmlRows = std::vector<std::pair<std::string, std::string>>;  // name, value

// Everything up to <body>. `style`: what the page has besides, CSS.
std::string html_head(const std::string& title, const std::string& style = "");

// A section with a table of names and values; "" when it has no row.
std::string html_table(const std::string& title, const HtmlRows& rows);

// A table of texts with a head; the first row is the head.
std::string html_grid(const std::vector<std::vector<std::string>>& rows);

// A picture inside the page.
std::string html_picture(const std::string& png, const std::string& alt);

std::string html_findings(const nlohmann::json& findings);

}  // namespace divemesh::worker
