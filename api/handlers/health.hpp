#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> get_liveness(Request request, Services services);
Awaitable<Response> get_readiness(Request request, Services services);
Awaitable<Response> get_openapi(Request request, Services services);

}  // namespace divemesh::api
