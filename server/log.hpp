#pragma once

#include <nlohmann/json.hpp>

namespace divemesh::server {

// One JSON object per line on stderr. Bytes that came from outside are escaped; tokens and bodies
// are never logged.
void start_log();
void log_info(const nlohmann::json& fields);
void log_warning(const nlohmann::json& fields);

}  // namespace divemesh::server
