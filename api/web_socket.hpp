#pragma once

#include <optional>

#include "api/http.hpp"

namespace divemesh::api {

// The answer to who asks for a WebSocket's address and for none: 426.
std::optional<Response> web_socket_refusal(const Request& request);

}  // namespace divemesh::api
