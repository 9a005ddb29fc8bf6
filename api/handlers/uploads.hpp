#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> describe_uploads(Request request, Services services);
Awaitable<Response> create_upload(Request request, Services services);
Awaitable<Response> get_upload_offset(Request request, Services services);
Awaitable<Response> get_upload(Request request, Services services);
Awaitable<Response> append_to_upload(Request request, Services services);
Awaitable<Response> terminate_upload(Request request, Services services);

}  // namespace divemesh::api
