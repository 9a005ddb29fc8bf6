#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace divemesh::bench {

// Returns the report of divemesh_envelope as Markdown: one row per step with the median over its
// runs and the worst, one row per axis with its edge.
std::string envelope_table(const nlohmann::json& report);

}  // namespace divemesh::bench
