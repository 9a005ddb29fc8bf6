#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> get_queue(Request request, Services services);
Awaitable<Response> get_usage(Request request, Services services);
Awaitable<Response> change_queue(Request request, Services services);
Awaitable<Response> redrive_queue(Request request, Services services);
Awaitable<Response> list_workers(Request request, Services services);
Awaitable<Response> get_worker(Request request, Services services);
Awaitable<Response> change_worker(Request request, Services services);

}  // namespace divemesh::api
