#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace divemesh::bench {

// Returns the report of divemesh_envelope as Markdown: one row for each step with median and worst
// over its runs, and one row for each axis with its edge.
std::string envelope_table(const nlohmann::json& report);

}  // namespace divemesh::bench
