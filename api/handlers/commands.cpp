#include "api/handlers/commands.hpp"

#include "api/audit.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/sensors/sensor_hub.hpp"
#include "api/visible.hpp"
#include "storage/command_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::int64_t kUsualLife_ms = 30'000;

storage::CommandRequest command_request(const Request& request) {
    const auto body = json_body(request, {"name", "arguments", "expires_in_ms"});
    storage::CommandRequest wanted{
        .sensor = request.parameter("sensor_id"),
        .name = value_or<std::string>(body, "name", ""),
        .arguments = body.value("arguments", nlohmann::json::object()),
        .life_ms = value_or<std::int64_t>(body, "expires_in_ms", kUsualLife_ms),
        .requested_by = request.token.id};
    check_command(wanted.name, wanted.arguments);
    if (wanted.life_ms < kMinCommandLife_ms || wanted.life_ms > kMaxCommandLife_ms)
        throw InvalidInput({{"\"expires_in_ms\" must be 1000 to 86400000", "/expires_in_ms", ""}});
    return wanted;
}

}  // namespace

Awaitable<Response> create_command(Request request, Services services) {
    auto work = [services, request] {
        visible_sensor(request, services.catalog);
        auto catalog = audited(services, request);
        return storage::CommandStore(catalog).create(command_request(request));
    };
    const SensorCommand command = co_await in_pool(services.pool, std::move(work));
    services.sensor_hub.call(command.sensor);
    Response response = json_response(http::status::created, command);
    response.set("Location", request.path + "/" + command.id);
    co_return response;
}

Awaitable<Response> list_commands(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        visible_sensor(asked, catalog);
        return storage::CommandStore(catalog).list(asked.parameter("sensor_id"),
                                                   page_request(asked));
    };
    return get_page(std::move(request), services, read);
}

Awaitable<Response> get_command(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        visible_sensor(asked, catalog);
        return storage::CommandStore(catalog).get(asked.parameter("sensor_id"),
                                                  asked.parameter("command_id"));
    };
    return get_resource(std::move(request), services, read);
}

}  // namespace divemesh::api
