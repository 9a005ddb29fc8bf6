#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

// Sessions of browsers.
namespace divemesh::api {

Awaitable<Response> create_session(Request request, Services services);
Awaitable<Response> get_session(Request request, Services services);
Awaitable<Response> end_session(Request request, Services services);

}  // namespace divemesh::api
