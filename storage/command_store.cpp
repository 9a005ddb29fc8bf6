#include "storage/command_store.hpp"

#include <algorithm>
#include <optional>

#include "schemas/error.hpp"
#include "storage/ids.hpp"
#include "storage/page_cursor.hpp"
#include "storage/sensor_events.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kMaxOpen = 20;    // per sensor
constexpr std::int64_t kMaxKept = 1000;  // per sensor

struct CommandRow {
    SensorCommand command;
    std::string arguments, state;

    void define(soci::statement& statement) {
        define_columns(statement,
                       command.id,
                       command.sensor,
                       command.name,
                       arguments,
                       state,
                       command.detail,
                       command.requested_by,
                       command.created_at_ms,
                       command.expires_at_ms,
                       command.sent_at_ms,
                       command.ended_at_ms);
    }
    SensorCommand value() const {
        SensorCommand value = command;
        value.arguments = nlohmann::json::parse(arguments);
        value.state = command_state_from_string(state);
        return value;
    }
};

const std::string kSelectCommands =
    "SELECT sensor_commands.id, sensors.id, name, arguments, sensor_commands.state, detail,"
    " requested_by, sensor_commands.created_at_ms, expires_at_ms, sent_at_ms, ended_at_ms"
    " FROM sensor_commands JOIN sensors ON sensors.number = sensor";
const std::string kIsOpen = "sensor_commands.state IN ('pending', 'sent')";

SensorRecord known_sensor(soci::session& session, const std::string& id) {
    auto record = find_sensor(session, id);
    if (!record) throw Error(ErrorCode::NotFound, "no sensor " + id);
    return std::move(*record);
}

void require_capability(const Sensor& sensor, const std::string& command) {
    const auto capabilities = sensor.hello.find("capabilities");
    const bool is_capable =
        capabilities != sensor.hello.end() &&
        std::find(capabilities->begin(), capabilities->end(), command) != capabilities->end();
    if (!is_capable)
        throw Error(ErrorCode::Conflict,
                    "sensor " + sensor.id + " does not support \"" + command +
                        "\": it is not in the capabilities of its hello");
}

void require_room(soci::session& session, const SensorRecord& sensor) {
    std::int64_t num_open = 0;
    session << "SELECT COUNT(*) FROM sensor_commands WHERE sensor = :sensor AND " + kIsOpen,
        soci::into(num_open), soci::use(sensor.number, "sensor");
    if (num_open >= kMaxOpen)
        throw Error(ErrorCode::TooMany,
                    "sensor " + sensor.sensor.id + " has not yet fetched " +
                        std::to_string(num_open) + " commands: wait until it has");
}

void append_command_event(soci::session& session,
                          const Sensor& sensor,
                          const SensorCommand& command) {
    append_sensor_event(session,
                        sensor,
                        "sensor.command",
                        {{"command", command.id},
                         {"name", command.name},
                         {"state", to_string(command.state)},
                         {"detail", command.detail}});
}

void save_state(soci::session& session, const SensorCommand& command) {
    const std::string state(to_string(command.state));
    execute(session,
            "UPDATE sensor_commands SET state = :state, detail = :detail, sent_at_ms = :sent,"
            " ended_at_ms = :ended WHERE id = :id",
            soci::use(state, "state"),
            soci::use(command.detail, "detail"),
            soci::use(command.sent_at_ms, "sent"),
            soci::use(command.ended_at_ms, "ended"),
            soci::use(command.id, "id"));
}

void insert(soci::session& session, const SensorRecord& sensor, const SensorCommand& command) {
    const std::string arguments = to_text(command.arguments);
    const std::string state(to_string(command.state));
    execute(session,
            "INSERT INTO sensor_commands (id, sensor, name, arguments, state, requested_by,"
            " created_at_ms, expires_at_ms) VALUES (:id, :sensor, :name, :arguments, :state, :by,"
            " :created, :expires)",
            soci::use(command.id, "id"),
            soci::use(sensor.number, "sensor"),
            soci::use(command.name, "name"),
            soci::use(arguments, "arguments"),
            soci::use(state, "state"),
            soci::use(command.requested_by, "by"),
            soci::use(command.created_at_ms, "created"),
            soci::use(command.expires_at_ms, "expires"));
    execute(session,
            "DELETE FROM sensor_commands WHERE sensor = :sensor AND number <= (SELECT number"
            " FROM sensor_commands WHERE sensor = :sensor ORDER BY number DESC"
            " LIMIT 1 OFFSET :kept)",
            soci::use(sensor.number, "sensor"),
            soci::use(kMaxKept, "kept"));
}

std::vector<SensorCommand> open_commands(soci::session& session,
                                         const std::string& sensor,
                                         bool again,
                                         std::int64_t now_ms) {
    const int with_sent = again ? 1 : 0;
    return select_all<CommandRow>(session,
                                  kSelectCommands +
                                      " WHERE sensors.id = :sensor AND expires_at_ms > :now"
                                      " AND (sensor_commands.state = 'pending'"
                                      " OR (:again = 1 AND sensor_commands.state = 'sent'))"
                                      " ORDER BY sensor_commands.number",
                                  soci::use(sensor, "sensor"),
                                  soci::use(now_ms, "now"),
                                  soci::use(with_sent, "again"));
}

}  // namespace

SensorCommand CommandStore::create(const CommandRequest& request) {
    SensorCommand command;
    catalog_.transaction([&](soci::session& session) {
        const SensorRecord sensor = known_sensor(session, request.sensor);
        require_capability(sensor.sensor, request.name);
        require_room(session, sensor);
        command = {};
        command.id = new_id("command");
        command.sensor = request.sensor;
        command.name = request.name;
        command.arguments = request.arguments;
        command.requested_by = request.requested_by;
        command.created_at_ms = Catalog::now_ms(session);
        command.expires_at_ms = command.created_at_ms + request.life_ms;
        insert(session, sensor, command);
        append_command_event(session, sensor.sensor, command);
    });
    return command;
}

Page<SensorCommand> CommandStore::list(const std::string& sensor, const PageRequest& page) {
    const PageStart start = page_start(page);
    std::vector<SensorCommand> commands;
    catalog_.read([&](soci::session& session) {
        commands = select_all<CommandRow>(session,
                                          kSelectCommands +
                                              " WHERE sensors.id = :sensor"
                                              " AND (sensor_commands.created_at_ms > :age"
                                              " OR (sensor_commands.created_at_ms = :age"
                                              " AND sensor_commands.id > :id))"
                                              " ORDER BY sensor_commands.created_at_ms,"
                                              " sensor_commands.id LIMIT :limit",
                                          soci::use(sensor, "sensor"),
                                          soci::use(start.created_at_ms, "age"),
                                          soci::use(start.id, "id"),
                                          soci::use(start.limit_plus_one, "limit"));
    });
    return make_page(std::move(commands), page);
}

SensorCommand CommandStore::get(const std::string& sensor, const std::string& id) {
    std::optional<SensorCommand> command;
    catalog_.read([&](soci::session& session) {
        command = select_one<CommandRow>(
            session,
            kSelectCommands + " WHERE sensors.id = :sensor AND sensor_commands.id = :id",
            soci::use(sensor, "sensor"),
            soci::use(id, "id"));
    });
    if (!command) throw Error(ErrorCode::NotFound, "no command " + id + " of sensor " + sensor);
    return std::move(*command);
}

std::vector<SensorCommand> CommandStore::take(const std::string& sensor, bool again) {
    std::vector<SensorCommand> commands;
    catalog_.read([&](soci::session& session) {
        commands = open_commands(session, sensor, again, Catalog::now_ms(session));
    });
    if (commands.empty()) return commands;  // avoids an empty write
    catalog_.transaction([&](soci::session& session) {
        const SensorRecord record = known_sensor(session, sensor);
        const std::int64_t now_ms = Catalog::now_ms(session);
        commands = open_commands(session, sensor, again, now_ms);
        for (SensorCommand& command : commands) {
            if (command.state == CommandState::Sent) continue;
            command.state = CommandState::Sent;
            command.sent_at_ms = now_ms;
            save_state(session, command);
            append_command_event(session, record.sensor, command);
        }
    });
    return commands;
}

void end_command(soci::session& session,
                 const SensorRecord& sensor,
                 const nlohmann::json& outcome,
                 std::int64_t now_ms) {
    const auto id = outcome.at("command").get<std::string>();
    auto command = select_one<CommandRow>(
        session,
        kSelectCommands + " WHERE sensor = :sensor AND sensor_commands.id = :id",
        soci::use(sensor.number, "sensor"),
        soci::use(id, "id"));
    if (!command) return;
    command->state = command_state_from_string(outcome.at("state").get<std::string>());
    command->detail = outcome.value("detail", "");
    command->ended_at_ms = now_ms;
    save_state(session, *command);
    append_command_event(session, sensor.sensor, *command);
}

bool has_late_commands(soci::session& session, std::int64_t now_ms) {
    return select_one<TextRow>(session,
                               "SELECT id FROM sensor_commands WHERE " + kIsOpen +
                                   " AND expires_at_ms <= :now LIMIT 1",
                               soci::use(now_ms, "now"))
        .has_value();
}

void end_late_commands(soci::session& session, std::int64_t now_ms) {
    auto late =
        select_all<CommandRow>(session,
                               kSelectCommands + " WHERE " + kIsOpen + " AND expires_at_ms <= :now",
                               soci::use(now_ms, "now"));
    for (SensorCommand& command : late) {
        command.detail = command.state == CommandState::Sent
                             ? "the sensor received the command and did not report the outcome"
                             : "the sensor did not fetch the command in time";
        command.state = CommandState::Expired;
        command.ended_at_ms = now_ms;
        save_state(session, command);
        append_command_event(session, known_sensor(session, command.sensor).sensor, command);
    }
}

}  // namespace divemesh::storage
