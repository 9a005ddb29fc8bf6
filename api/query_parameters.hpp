#pragma once

#include "api/http.hpp"
#include "api/routes.hpp"

namespace divemesh::api {

// Checks that api/openapi.yaml lists every query parameter of a request to this route. Throws
// InvalidInput, which names the nearest one that it lists.
void require_known_query(const Request& request, const Route& route);

}  // namespace divemesh::api
