#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> list_dives(Request request, Services services);
Awaitable<Response> create_dive(Request request, Services services);
Awaitable<Response> get_dive(Request request, Services services);
Awaitable<Response> list_findings(Request request, Services services);

}  // namespace divemesh::api
