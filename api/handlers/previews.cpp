#include "api/handlers/previews.hpp"

#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/target.hpp"
#include "api/visible.hpp"
#include "schemas/error.hpp"
#include "storage/preview_store.hpp"

namespace divemesh::api {
namespace {

// States the image's age, so that a frozen image is never taken for a live one.
Response image_response(storage::StoredPreview stored) {
    Response response = empty_response(http::status::ok);
    response.set("Content-Type", "image/jpeg");
    response.set("Last-Modified", http_date(stored.preview.time_ms / 1000));
    response.set("Age", std::to_string(stored.age_ms / 1000));
    response.body = std::move(stored.jpeg);
    return response;
}

}  // namespace

Awaitable<Response> list_previews(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        visible_sensor(asked, catalog);
        return storage::PreviewStore(catalog).list(asked.parameter("sensor_id"));
    };
    return get_list(std::move(request), services, read);
}

Awaitable<Response> get_preview(Request request, Services services) {
    auto work = [&catalog = services.catalog, request] {
        const std::string& sensor = request.parameter("sensor_id");
        visible_sensor(request, catalog);
        const auto id = parse_count(request.parameter("preview_id"));
        if (!id) throw Error(ErrorCode::NotFound, "the number of a preview must be a whole number");
        return storage::PreviewStore(catalog).get(sensor, *id);
    };
    co_return image_response(co_await in_pool(services.pool, std::move(work)));
}

Awaitable<Response> get_newest_preview(Request request, Services services) {
    auto work = [&catalog = services.catalog, request] {
        const std::string& sensor = request.parameter("sensor_id");
        visible_sensor(request, catalog);
        return storage::PreviewStore(catalog).newest(sensor, query_value(request, "camera"));
    };
    co_return image_response(co_await in_pool(services.pool, std::move(work)));
}

}  // namespace divemesh::api
