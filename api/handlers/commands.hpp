#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> create_command(Request request, Services services);
Awaitable<Response> list_commands(Request request, Services services);
Awaitable<Response> get_command(Request request, Services services);

}  // namespace divemesh::api
