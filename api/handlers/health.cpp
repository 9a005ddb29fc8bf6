#include "api/handlers/health.hpp"

#include <nlohmann/json.hpp>

#include "api/in_pool.hpp"
#include "api/openapi_document.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {

Awaitable<Response> get_liveness(Request, Services) {
    co_return json_response(http::status::ok, {{"status", "live"}});
}

Awaitable<Response> get_readiness(Request, Services services) {
    auto check = [services] {
        services.catalog.schema_version();
        return services.blobs.free_bytes();
    };
    const std::int64_t free_bytes = co_await in_pool(services.pool, std::move(check));
    if (free_bytes < services.limits.min_free_bytes)
        throw Error(ErrorCode::Unavailable,
                    "the disk has " + std::to_string(free_bytes >> 20) + " MiB left: free some");
    co_return json_response(http::status::ok, {{"status", "ready"}, {"free_bytes", free_bytes}});
}

Awaitable<Response> get_openapi(Request, Services) {
    Response response = empty_response(http::status::ok);
    response.body = std::string(openapi_document());
    response.set("Content-Type", "application/json");
    co_return response;
}

}  // namespace divemesh::api
