#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace divemesh::report {

// Fills a mustache template. {{name}} is replaced by the escaped value, {{{name}}} by a value that
// already is HTML or SVG. {{#name}}...{{/name}} is repeated for each item of a list, appears once
// for true or an object, whose names it can use, and is left out for an empty list, false or null;
// {{^name}}...{{/name}} is the opposite. {{.}} is the item itself, {{>name}} one of the parts in
// html_parts.hpp. Throws std::logic_error for a name that is not in `values`, an unknown part and a
// malformed template.
std::string fill_template(std::string_view text, const nlohmann::json& values);

}  // namespace divemesh::report
