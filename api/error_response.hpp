#pragma once

#include <exception>
#include <string>

#include "api/http.hpp"

namespace divemesh::api {

// Returns the response for an error: the only mapping of errors to HTTP, as
// application/problem+json (RFC 9457). An Error shows its message; any other exception is logged
// and shown as "internal error" with the request's id.
Response error_response(const Request& request, const std::exception_ptr& failure);

// Returns the response for a refusal of HTTP itself: 405, 412, 416, 426, 431.
Response problem_response(const Request& request, http::status status, const std::string& detail);

}  // namespace divemesh::api
