#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Truth that came after its dive. It is sent as an upload, see api/uploads/upload_metadata.hpp.
Awaitable<Response> list_truth(Request request, Services services);
Awaitable<Response> get_truth(Request request, Services services);
Awaitable<Response> delete_truth(Request request, Services services);

}  // namespace divemesh::api
