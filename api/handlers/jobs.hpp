#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> list_jobs(Request request, Services services);
Awaitable<Response> create_job(Request request, Services services);
Awaitable<Response> get_job(Request request, Services services);
Awaitable<Response> change_job(Request request, Services services);
Awaitable<Response> cancel_job(Request request, Services services);
Awaitable<Response> retry_job(Request request, Services services);
Awaitable<Response> get_job_log(Request request, Services services);
Awaitable<Response> list_attempts(Request request, Services services);
Awaitable<Response> get_attempt_log(Request request, Services services);
Awaitable<Response> list_artifacts(Request request, Services services);

}  // namespace divemesh::api
