#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> watch_events(Request request, Services services);

}  // namespace divemesh::api
