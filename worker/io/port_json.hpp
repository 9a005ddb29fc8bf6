#pragma once

#include <nlohmann/json.hpp>

#include "worker/types/port.hpp"

namespace divemesh::io {

// A port as our JSON files have it, in the frame of its camera. Reading throws Error{BadData} for a
// type that is unknown, nlohmann::json::exception for a value that is missing.
nlohmann::json to_json(const types::Port& port);
types::Port port_from_json(const nlohmann::json& entry);

}  // namespace divemesh::io
