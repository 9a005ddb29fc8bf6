#pragma once

#include <nlohmann/json.hpp>

namespace divemesh {

// Log one JSON object on one line, in server and worker alike, so that one reader follows both.
// External bytes are escaped; tokens and bodies are never logged. Each process chooses the target
// (server/log.hpp); the default is stdout.
void log_info(const nlohmann::json& fields);
void log_warning(const nlohmann::json& fields);
void log_error(const nlohmann::json& fields);

}  // namespace divemesh
