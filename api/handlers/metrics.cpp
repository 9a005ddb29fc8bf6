#include "api/handlers/metrics.hpp"

#include "api/in_pool.hpp"
#include "api/metrics.hpp"

namespace divemesh::api {

Awaitable<Response> get_metrics(Request, Services services) {
    auto work = [services] {
        return services.metrics.text(storage::read_statistics(services.catalog),
                                     services.blobs.free_bytes());
    };
    Response response = empty_response(http::status::ok);
    response.body = co_await in_pool(services.pool, std::move(work));
    response.set("Content-Type", "text/plain; version=0.0.4; charset=utf-8");
    response.set("Cache-Control", "no-store");
    co_return response;
}

}  // namespace divemesh::api
