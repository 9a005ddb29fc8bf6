#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Scheduled accuracy reports.
Awaitable<Response> list_schedules(Request request, Services services);
Awaitable<Response> create_schedule(Request request, Services services);
Awaitable<Response> get_schedule(Request request, Services services);
Awaitable<Response> delete_schedule(Request request, Services services);

}  // namespace divemesh::api
