#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> list_tokens(Request request, Services services);
Awaitable<Response> create_token(Request request, Services services);
Awaitable<Response> revoke_token(Request request, Services services);
Awaitable<Response> create_one_shot_token(Request request, Services services);

}  // namespace divemesh::api
