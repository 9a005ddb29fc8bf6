#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> get_artifact(Request request, Services services);
Awaitable<Response> get_artifacts_archive(Request request, Services services);
Awaitable<Response> get_thumbnail(Request request, Services services);
Awaitable<Response> get_truth_content(Request request, Services services);

}  // namespace divemesh::api
