#pragma once

#include <optional>
#include <vector>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Returns whether the request's Origin is this server: that of its public address, or the name in
// the Host field. Behind a proxy the server does not know whether it is reached by TLS, and the
// proxy may send a Host of its own.
bool is_own_origin(const Request& request, const ServiceLimits& limits);

// Returns whether a page of the request's Origin may use this server: there is no Origin (not a
// browser), it is this server, or it is on the list. The origin "null" is never allowed.
bool is_allowed_origin(const Request& request, const ServiceLimits& limits);

// Returns the response to a preflight (Fetch standard, CORS); nullopt if the request is not a
// preflight or its origin is not allowed.
std::optional<Response> answer_preflight(const Request& request,
                                         const std::vector<verb>& methods,
                                         const ServiceLimits& limits);

// Lets a page of an origin on the list read the response. With an empty list it adds no header.
void add_cors(const Request& request, const ServiceLimits& limits, Response& response);

}  // namespace divemesh::api
