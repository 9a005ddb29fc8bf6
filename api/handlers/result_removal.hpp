#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> delete_job(Request request, Services services);
Awaitable<Response> restore_job(Request request, Services services);

}  // namespace divemesh::api
