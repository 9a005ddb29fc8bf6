#include "storage/sensor_history.hpp"

#include <algorithm>

#include "schemas/error.hpp"
#include "storage/sensor_rows.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kDay_ms = 86'400'000;

std::string columns_of(const std::vector<std::string>& fields) {
    std::string columns;
    for (const std::string& field : fields) {
        if (find_status_field(field) == nullptr)
            throw Error(ErrorCode::InvalidArgument, "a status has no number \"" + field + "\"");
        columns += ", " + field;
    }
    return columns;
}

SensorHistory frame_of(const HistoryRequest& request, std::int64_t now_ms) {
    SensorHistory history;
    history.to_ms = request.to_ms.value_or(now_ms + 1);
    history.from_ms = request.from_ms.value_or(std::max<std::int64_t>(0, history.to_ms - kDay_ms));
    if (history.from_ms >= history.to_ms)
        throw Error(ErrorCode::InvalidArgument, "\"from\" is not before \"to\"");
    history.step_ms = (history.to_ms - history.from_ms + request.num_steps - 1) / request.num_steps;
    history.fields = request.fields;
    return history;
}

// Combines statuses, in order of time, step by step. SQLite would sort them into groups, which
// takes twice as long as reading them.
class Thinning {
public:
    explicit Thinning(SensorHistory& history) : history_(history), counts_(history.fields.size()) {}

    // `values` and `known` have one entry per field.
    void add(std::int64_t time_ms,
             const std::vector<double>& values,
             const std::vector<soci::indicator>& known) {
        const std::int64_t number = (time_ms - history_.from_ms) / history_.step_ms;
        if (history_.steps.empty() || number != number_) begin(number);
        SensorHistory::Step& step = history_.steps.back();
        ++step.num_statuses;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (known[i] != soci::i_ok) continue;
            if (!step.values[i]) step.values[i] = {values[i], 0.0, values[i]};
            SensorHistory::Value& value = *step.values[i];
            value.min = std::min(value.min, values[i]);
            value.max = std::max(value.max, values[i]);
            value.mean += (values[i] - value.mean) / static_cast<double>(++counts_[i]);
        }
    }

private:
    void begin(std::int64_t number) {
        number_ = number;
        std::fill(counts_.begin(), counts_.end(), 0);
        SensorHistory::Step step;
        step.time_ms = history_.from_ms + number * history_.step_ms;
        step.values.resize(history_.fields.size());
        history_.steps.push_back(std::move(step));
    }

    SensorHistory& history_;
    std::int64_t number_ = 0;
    std::vector<std::int64_t> counts_;  // within the step, by field
};

void read_steps(soci::session& session, std::int64_t sensor, SensorHistory& history) {
    std::int64_t time_ms = 0;
    std::vector<double> values(history.fields.size());
    std::vector<soci::indicator> known(values.size());
    fault_point();
    soci::statement statement(session);
    statement.exchange(soci::into(time_ms));
    for (std::size_t i = 0; i < values.size(); ++i)
        statement.exchange(soci::into(values[i], known[i]));
    statement.exchange(soci::use(sensor, "sensor"));
    statement.exchange(soci::use(history.from_ms, "from"));
    statement.exchange(soci::use(history.to_ms, "to"));
    statement.alloc();
    statement.prepare("SELECT time_ms" + columns_of(history.fields) +
                      " FROM sensor_statuses WHERE sensor = :sensor AND time_ms >= :from"
                      " AND time_ms < :to ORDER BY time_ms");
    statement.define_and_bind();
    statement.execute(false);
    Thinning thinning(history);
    while (statement.fetch()) thinning.add(time_ms, values, known);
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
