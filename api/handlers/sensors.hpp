#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> open_sensor_stream(Request request, Services);
Awaitable<Response> push_sensor_status(Request request, Services services);
Awaitable<Response> list_sensors(Request request, Services services);
Awaitable<Response> get_sensor(Request request, Services services);
Awaitable<Response> get_sensor_history(Request request, Services services);

}  // namespace divemesh::api
