#include "api/handlers/sensors.hpp"

#include "api/authorization.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/sensors/report_queue.hpp"
#include "api/target.hpp"
#include "api/visible.hpp"
#include "api/web_socket.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/json.hpp"
#include "storage/sensor_history.hpp"
#include "storage/sensor_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::int64_t kMaxStepCount = 5000;
constexpr std::size_t kMaxHistoryFields = 16;
constexpr std::int64_t kMaxTime_ms = std::int64_t{1} << 52;

std::vector<std::string> fields_of(const Request& request) {
    std::vector<std::string> fields = split_list(query_value(request, "fields"));
    std::vector<Fault> faults;
    for (const std::string& field : fields)
        if (find_status_field(field) == nullptr)
            faults.push_back(
                {"\"fields\" names \"" + field + "\", which is not a number of a status",
                 "",
                 "fields"});
    if (fields.size() > kMaxHistoryFields)
        faults.push_back(
            {"\"fields\" must name at most " + std::to_string(kMaxHistoryFields), "", "fields"});
    if (!faults.empty()) throw InvalidInput(std::move(faults));
    return fields;
}

storage::HistoryRequest history_request(const Request& request) {
    storage::HistoryRequest wanted;
    wanted.sensor = request.parameter("sensor_id");
    if (request.query.contains("to")) wanted.to_ms = time_value(request, "to", 0);
    if (request.query.contains("from")) wanted.from_ms = time_value(request, "from", 0);
    if (wanted.to_ms.value_or(0) > kMaxTime_ms || wanted.from_ms.value_or(0) > kMaxTime_ms ||
        (wanted.from_ms && wanted.to_ms && *wanted.from_ms >= *wanted.to_ms))
        throw InvalidInput({{"\"from\" must be before \"to\"", "", "from"}});
    wanted.fields = fields_of(request);
    if (!request.query.contains("steps")) return wanted;
    const auto steps = parse_count(query_value(request, "steps"));
    if (!steps || *steps < 1 || *steps > kMaxStepCount)
        throw InvalidInput({{"steps must be 1 to " + std::to_string(kMaxStepCount), "", "steps"}});
    wanted.num_steps = static_cast<int>(*steps);
    return wanted;
}

// Returns the sensor of the path, which must be that of the token.
std::string speaking_sensor(const Request& request) {
    const std::string& sensor = request.parameter("sensor_id");
    require_sensor(request.token, sensor);
    if (!is_plain_word(sensor))
        throw Error(ErrorCode::InvalidArgument,
                    "the id of a sensor must be a-z 0-9 _ -, beginning with a letter or digit");
    return sensor;
}

}  // namespace

Awaitable<Response> open_sensor_stream(Request request, Services) {
    const std::string sensor = speaking_sensor(request);
    if (auto refused = web_socket_refusal(request)) co_return std::move(*refused);
    Response response = empty_response(http::status::switching_protocols);
    response.body = SensorStream{sensor, request.token.project, request.token.id};
    co_return response;
}

Awaitable<Response> push_sensor_status(Request request, Services services) {
    const std::string sensor = speaking_sensor(request);
    storage::IncomingReport report{
        sensor,
        request.token.project,
        sensor_report(json_body(request, {"boot_id", "messages", "lost"}))};
    const SensorAnswer answer = co_await services.reports.submit(std::move(report));
    co_return json_response(http::status::ok, answer);
}

Awaitable<Response> list_sensors(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::SensorStore(catalog).list(visible_project(asked.token),
                                                  page_request(asked));
    };
    return get_page(std::move(request), services, read);
}

Awaitable<Response> get_sensor(Request request, Services services) {
    return get_resource(std::move(request), services, visible_sensor);
}

Awaitable<Response> get_sensor_history(Request request, Services services) {
    auto work = [&catalog = services.catalog, request] {
        visible_sensor(request, catalog);
        return storage::read_history(catalog, history_request(request));
    };
    const SensorHistory history = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, history);
}

}  // namespace divemesh::api
