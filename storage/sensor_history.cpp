#include "storage/sensor_history.hpp"

#include <algorithm>

#include "schemas/error.hpp"
#include "storage/sensor_rows.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kDay_ms = 86'400'000;
// As many values a field as SensorHistory::Value has.
constexpr std::size_t kPerField = 3;

std::string columns_of(const std::vector<std::string>& fields) {
    std::string columns;
    for (const std::string& field : fields) {
        if (find_status_field(field) == nullptr)
            throw Error(ErrorCode::InvalidArgument, "a status has no number \"" + field + "\"");
        columns += ", MIN(" + field + "), AVG(" + field + "), MAX(" + field + ")";
    }
    return columns;
}

SensorHistory frame_of(const HistoryRequest& request, std::int64_t now_ms) {
    SensorHistory history;
    history.to_ms = request.to_ms.value_or(now_ms + 1);
    history.from_ms = request.from_ms.value_or(std::max<std::int64_t>(0, history.to_ms - kDay_ms));
    if (history.from_ms >= history.to_ms)
        throw Error(ErrorCode::InvalidArgument, "the history ends before it begins");
    history.step_ms = (history.to_ms - history.from_ms + request.num_steps - 1) / request.num_steps;
    history.fields = request.fields;
    return history;
}

void read_steps(soci::session& session, std::int64_t sensor, SensorHistory& history) {
    std::int64_t number = 0;
    SensorHistory::Step step;
    std::vector<double> values(kPerField * history.fields.size());
    std::vector<soci::indicator> known(values.size());
    fault_point();
    soci::statement statement(session);
    statement.exchange(soci::into(number));
    statement.exchange(soci::into(step.num_statuses));
    for (std::size_t i = 0; i < values.size(); ++i)
        statement.exchange(soci::into(values[i], known[i]));
    statement.exchange(soci::use(history.from_ms, "from"));
    statement.exchange(soci::use(history.step_ms, "step"));
    statement.exchange(soci::use(sensor, "sensor"));
    statement.exchange(soci::use(history.to_ms, "to"));
    statement.alloc();
    statement.prepare("SELECT (time_ms - :from) / :step AS step, COUNT(*)" +
                      columns_of(history.fields) +
                      " FROM sensor_statuses WHERE sensor = :sensor AND time_ms >= :from"
                      " AND time_ms < :to GROUP BY step ORDER BY step");
    statement.define_and_bind();
    statement.execute(false);
    while (statement.fetch()) {
        step.time_ms = history.from_ms + number * history.step_ms;
        step.values.clear();
        for (std::size_t i = 0; i < values.size(); i += kPerField)
            step.values.push_back(
                known[i] == soci::i_ok
                    ? std::optional<SensorHistory::Value>({values[i], values[i + 1], values[i + 2]})
                    : std::nullopt);
        history.steps.push_back(step);
    }
}

}  // namespace

SensorHistory read_history(Catalog& catalog, const HistoryRequest& request) {
    SensorHistory history;
    catalog.read([&](soci::session& session) {
        const auto sensor = find_sensor(session, request.sensor);
        if (!sensor) throw Error(ErrorCode::NotFound, "no sensor " + request.sensor);
        history = frame_of(request, Catalog::now_ms(session));
        read_steps(session, sensor->number, history);
    });
    return history;
}

}  // namespace divemesh::storage
