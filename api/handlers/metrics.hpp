#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> get_metrics(Request request, Services services);

}  // namespace divemesh::api
