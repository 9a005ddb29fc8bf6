#pragma once

#include <optional>

#include "api/http.hpp"

namespace divemesh::api {

// Returns 426 for a request to a WebSocket's address that does not ask for a WebSocket; otherwise
// nullopt.
std::optional<Response> web_socket_refusal(const Request& request);

}  // namespace divemesh::api
