#pragma once

#include <optional>
#include <vector>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Whether a page of the request's Origin may talk to us: there is none (no browser), it is our own,
// or it is on the list. An origin of "null" is nobody's.
bool is_allowed_origin(const Request& request, const ServiceLimits& limits);

// The answer to a preflight (Fetch standard, CORS); nothing when the request is none or its origin
// may not.
std::optional<Response> answer_preflight(const Request& request,
                                         const std::vector<verb>& methods,
                                         const ServiceLimits& limits);

// Lets a page of an origin on the list read the answer. Without the list nobody gets a header.
void add_cors(const Request& request, const ServiceLimits& limits, Response& response);

}  // namespace divemesh::api
