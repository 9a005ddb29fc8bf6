#pragma once

#include <nlohmann/json.hpp>

namespace divemesh {

// Log one JSON object, on one line, of server and worker alike: one reader follows both. Bytes that
// came from outside are escaped; tokens and bodies are never logged. Where it goes is decided by
// the process (server/log.hpp), by default stdout.
void log_info(const nlohmann::json& fields);
void log_warning(const nlohmann::json& fields);
void log_error(const nlohmann::json& fields);

}  // namespace divemesh
