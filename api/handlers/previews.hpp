#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> list_previews(Request request, Services services);
Awaitable<Response> get_preview(Request request, Services services);
Awaitable<Response> get_newest_preview(Request request, Services services);

}  // namespace divemesh::api
