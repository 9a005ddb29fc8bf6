#include "api/handlers/health.hpp"

#include <nlohmann/json.hpp>

#include "api/in_pool.hpp"
#include "api/openapi_document.hpp"
#include "api/readiness.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {

Awaitable<Response> get_liveness(Request, Services) {
    co_return json_response(http::status::ok, {{"status", "live"}});
}

Awaitable<Response> get_readiness(Request, Services services) {
    auto look = [services] { return services.readiness.check(services); };
    const Readiness::Result result = co_await in_pool(services.pool, std::move(look));
    if (!result.failure.empty()) throw Error(ErrorCode::Unavailable, result.failure);
    nlohmann::json ready = {{"status", "ready"}, {"free_bytes", result.free_bytes}};
    if (!result.queue_waits_for.empty()) ready["queue_waits_for"] = result.queue_waits_for;
    co_return json_response(http::status::ok, ready);
}

Awaitable<Response> get_openapi(Request, Services) {
    Response response = empty_response(http::status::ok);
    response.body = std::string(openapi_json());
    response.set("Content-Type", "application/json");
    co_return response;
}

}  // namespace divemesh::api
