#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

Awaitable<Response> list_webhooks(Request request, Services services);
Awaitable<Response> create_webhook(Request request, Services services);
Awaitable<Response> delete_webhook(Request request, Services services);
Awaitable<Response> enable_webhook(Request request, Services services);
Awaitable<Response> list_webhook_deliveries(Request request, Services services);
Awaitable<Response> redeliver_webhook(Request request, Services services);

}  // namespace divemesh::api
