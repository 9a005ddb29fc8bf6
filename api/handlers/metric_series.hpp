#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Returns one metric over dives and time.
Awaitable<Response> get_metric_series(Request request, Services services);
Awaitable<Response> list_metrics(Request request, Services services);

}  // namespace divemesh::api
