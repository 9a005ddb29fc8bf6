#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> list_shares(Request request, Services services);
Awaitable<Response> create_share(Request request, Services services);
Awaitable<Response> withdraw_share(Request request, Services services);

}  // namespace divemesh::api
