#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> edit_dive(Request request, Services services);

}  // namespace divemesh::api
