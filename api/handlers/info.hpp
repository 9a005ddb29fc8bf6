#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// What a client can ask before it sends work: the server's version and limits, and the options of
// each kind of job.
Awaitable<Response> get_info(Request request, Services services);
Awaitable<Response> get_options(Request request, Services services);

}  // namespace divemesh::api
