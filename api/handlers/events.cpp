#include "api/handlers/events.hpp"

#include <algorithm>

#include "api/authorization.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/sensors/sensor_hub.hpp"
#include "api/target.hpp"
#include "api/web_socket.hpp"
#include "schemas/invalid_input.hpp"
#include "storage/event_store.hpp"
#include "storage/sensor_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxSensors = 100;

// Throws unless all events after `since` are known. After a restored backup a client may have seen
// newer events than there are, and after a long time old events are gone; it would miss events
// without notice. 0 means from the oldest event.
void require_known(storage::EventStore events, std::int64_t since) {
    if (since > events.newest_sequence())
        throw Error(ErrorCode::Gone,
                    "this event does not exist, because the catalog was restored: read the lists "
                    "and connect without since");
    if (since > 0 && since + 1 < events.oldest_sequence())
        throw Error(ErrorCode::Gone,
                    "events after this one are too old and were removed: read the lists and "
                    "connect without since");
}

// Returns the sensors to watch live and introduces them to the sensor hub.
std::vector<std::string> watched_sensors(const Request& request, const Services& services) {
    auto ids = split_list(query_value(request, "sensors"));
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    if (ids.size() > kMaxSensors)
        throw InvalidInput(
            {{"\"sensors\" must name at most " + std::to_string(kMaxSensors), "", "sensors"}});
    for (const std::string& id : ids) {
        const Sensor sensor = storage::SensorStore(services.catalog).get(id);
        require_visible(request.token, sensor.project, "sensor " + id);
        services.sensor_hub.introduce(sensor);
    }
    return ids;
}

}  // namespace

Awaitable<Response> watch_events(Request request, Services services) {
    if (auto refused = web_socket_refusal(request)) co_return std::move(*refused);
    EventFeed feed{0, visible_project(request.token), request.token.id, {}};
    if (request.query.contains("sensors")) {
        auto find = [services, request] { return watched_sensors(request, services); };
        feed.sensors = co_await in_pool(services.pool, std::move(find));
    }
    if (request.query.contains("since")) {
        const auto since = parse_count(query_value(request, "since"));
        if (!since)
            throw Error(ErrorCode::InvalidArgument, "since must be the sequence of an event");
        feed.since = *since;
        auto check = [&catalog = services.catalog, since = *since] {
            require_known(storage::EventStore(catalog), since);
        };
        co_await in_pool(services.pool, std::move(check));
    } else {
        auto newest = [&catalog = services.catalog] {
            return storage::EventStore(catalog).newest_sequence();
        };
        feed.since = co_await in_pool(services.pool, std::move(newest));
    }
    Response response = empty_response(http::status::switching_protocols);
    response.body = feed;
    co_return response;
}

}  // namespace divemesh::api
