#include "storage/sensor_rows.hpp"

#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

struct BootRow {
    BootRecord boot;
    std::int64_t epoch_ms = 0;
    soci::indicator has_epoch = soci::i_null;
    std::string received;

    void define(soci::statement& statement) {
        define_columns(statement, boot.number, boot.boot_id, boot.life);
        statement.exchange(soci::into(epoch_ms, has_epoch));
        statement.exchange(soci::into(received));
    }
    BootRecord value() const {
        BootRecord value = boot;
        if (has_epoch == soci::i_ok) value.epoch_ms = epoch_ms;
        value.received = nlohmann::json::parse(received).get<SequenceRanges>();
        return value;
    }
};

}  // namespace

const std::string kSelectSensors =
    "SELECT sensors.number, id, project, state, alarms, boot, num_lives, hello, status,"
    " status_at_ms, status_sequence, previews, sensors.seen_at_ms, back_at_ms, twin_at_ms, "
    "created_at_ms,"
    " COALESCE(boot_id, ''), COALESCE(received, '')"
    " FROM sensors LEFT JOIN sensor_boots"
    " ON sensor_boots.sensor = sensors.number AND sensor_boots.number = boot";

void SensorRow::define(soci::statement& statement) {
    Sensor& sensor = record.sensor;
    define_columns(statement,
                   record.number,
                   sensor.id,
                   sensor.project,
                   state,
                   alarms,
                   record.boot,
                   record.num_lives,
                   hello,
                   status,
                   sensor.status_at_ms,
                   record.status_sequence,
                   previews,
                   sensor.seen_at_ms,
                   sensor.back_at_ms,
                   record.twin_at_ms,
                   sensor.created_at_ms,
                   sensor.boot_id,
                   received);
}

SensorRecord SensorRow::value() const {
    SensorRecord value = record;
    value.sensor.state = sensor_state_from_string(state);
    value.sensor.alarms = nlohmann::json::parse(alarms).get<std::vector<Alarm>>();
    value.sensor.hello = nlohmann::json::parse(hello);
    value.sensor.status = nlohmann::json::parse(status);
    value.sensor.previews = nlohmann::json::parse(previews).get<std::map<std::string, Preview>>();
    if (!received.empty())
        value.sensor.received = nlohmann::json::parse(received).get<SequenceRanges>();
    return value;
}

std::optional<SensorRecord> find_sensor(soci::session& session, const std::string& id) {
    return select_one<SensorRow>(session, kSelectSensors + " WHERE id = :id", soci::use(id, "id"));
}

std::optional<BootRecord> find_boot(soci::session& session,
                                    std::int64_t sensor,
                                    const std::string& boot_id) {
    return select_one<BootRow>(session,
                               "SELECT number, boot_id, life, epoch_ms, received FROM sensor_boots"
                               " WHERE sensor = :sensor AND boot_id = :boot",
                               soci::use(sensor, "sensor"),
                               soci::use(boot_id, "boot"));
}

void save_boot(soci::session& session,
               std::int64_t sensor,
               const BootRecord& boot,
               std::int64_t now_ms) {
    const std::string received = to_text(boot.received);
    const std::int64_t epoch_ms = boot.epoch_ms.value_or(0);
    soci::indicator has_epoch = boot.epoch_ms ? soci::i_ok : soci::i_null;
    execute(session,
            "INSERT INTO sensor_boots (sensor, number, boot_id, life, epoch_ms, received,"
            " seen_at_ms) VALUES (:sensor, :number, :boot, :life, :epoch, :received, :now)"
            " ON CONFLICT (sensor, number) DO UPDATE SET life = excluded.life,"
            " epoch_ms = excluded.epoch_ms, received = excluded.received,"
            " seen_at_ms = excluded.seen_at_ms",
            soci::use(sensor, "sensor"),
            soci::use(boot.number, "number"),
            soci::use(boot.boot_id, "boot"),
            soci::use(boot.life, "life"),
            soci::use(epoch_ms, has_epoch, "epoch"),
            soci::use(received, "received"),
            soci::use(now_ms, "now"));
}

void save_sensor(soci::session& session, const SensorRecord& record) {
    const Sensor& sensor = record.sensor;
    const std::string state(to_string(sensor.state));
    const std::string alarms = to_text(sensor.alarms);
    const std::string hello = to_text(sensor.hello);
    const std::string status = to_text(sensor.status);
    const std::string previews = to_text(sensor.previews);
    execute(session,
            "UPDATE sensors SET state = :state, alarms = :alarms, boot = :boot,"
            " num_lives = :lives, hello = :hello, status = :status, status_at_ms = :status_at,"
            " status_sequence = :sequence, previews = :previews, seen_at_ms = :seen, back_at_ms = "
            ":back,"
            " twin_at_ms = :twin WHERE number = :number",
            soci::use(state, "state"),
            soci::use(alarms, "alarms"),
            soci::use(record.boot, "boot"),
            soci::use(record.num_lives, "lives"),
            soci::use(hello, "hello"),
            soci::use(status, "status"),
            soci::use(sensor.status_at_ms, "status_at"),
            soci::use(record.status_sequence, "sequence"),
            soci::use(previews, "previews"),
            soci::use(sensor.seen_at_ms, "seen"),
            soci::use(sensor.back_at_ms, "back"),
            soci::use(record.twin_at_ms, "twin"),
            soci::use(record.number, "number"));
}

}  // namespace divemesh::storage
