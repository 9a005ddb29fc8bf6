#pragma once

#include <nlohmann/json.hpp>

namespace divemesh::worker {

// What the parent of a worker logs: one JSON object, on one line. What recordings brought, names
// and messages, is escaped in it.
void log_info(const nlohmann::json& fields);
void log_warning(const nlohmann::json& fields);

}  // namespace divemesh::worker
