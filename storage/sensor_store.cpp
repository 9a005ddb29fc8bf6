#include "storage/sensor_store.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "storage/command_store.hpp"
#include "storage/page_cursor.hpp"
#include "storage/preview_store.hpp"
#include "storage/sensor_events.hpp"
#include "storage/sensor_rows.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

using nlohmann::json;

// A device's time is trusted if it is at most so far ahead of, and behind, the catalog's clock. If
// the boot time it implies moves ahead by more, its uptime has stood still.
constexpr std::int64_t kMaxAhead_ms = 60'000;
constexpr std::int64_t kMaxBack_ms = std::int64_t{366} * 86'400'000;
constexpr std::int64_t kTwinForgotten_ms = 60'000;
constexpr std::int64_t kMaxBoots = 1000;  // per sensor; with more the oldest is dropped
constexpr std::size_t kMaxCameras = 8;    // shown ones
constexpr int kForgottenAtOnce = 20'000;

void append_alarm_event(soci::session& session,
                        const Sensor& sensor,
                        const Alarm& alarm,
                        bool raised) {
    json data = alarm;
    data["raised"] = raised;
    append_sensor_event(session, sensor, "sensor.alarm", std::move(data));
}

const Alarm* find_alarm(const std::vector<Alarm>& alarms, const std::string& name) {
    const auto found = std::find_if(
        alarms.begin(), alarms.end(), [&](const Alarm& alarm) { return alarm.name == name; });
    return found == alarms.end() ? nullptr : &*found;
}

// Appends events for new and ended alarms. A changed detail of an alarm makes no event.
void set_alarms(soci::session& session, Sensor& sensor, std::vector<Alarm> alarms) {
    for (const Alarm& alarm : alarms) {
        const Alarm* before = find_alarm(sensor.alarms, alarm.name);
        if (before == nullptr || before->level != alarm.level)
            append_alarm_event(session, sensor, alarm, true);
    }
    for (const Alarm& alarm : sensor.alarms)
        if (find_alarm(alarms, alarm.name) == nullptr)
            append_alarm_event(session, sensor, alarm, false);
    sensor.alarms = std::move(alarms);
}

// Returns true for the alarms that do not come from a status.
bool is_ours(const Alarm& alarm) { return alarm.name == "overdue" || alarm.name == "twin"; }

void set_state(soci::session& session, Sensor& sensor, SensorState state) {
    if (sensor.state == state) return;
    sensor.state = state;
    append_sensor_event(session,
                        sensor,
                        "sensor.state",
                        {{"state", to_string(state)}, {"back_at_ms", sensor.back_at_ms}});
}

class Receiver {
public:
    Receiver(soci::session& session,
             SensorRecord record,
             BootRecord boot,
             std::int64_t now_ms,
             int max_previews)
        : session_(session),
          record_(std::move(record)),
          boot_(std::move(boot)),
          now_ms_(now_ms),
          max_previews_(max_previews) {}

    ReportOutcome receive(const SensorReport& report) {
        answer_.boot_id = boot_.boot_id;
        answer_.time_ms = now_ms_;
        // Current messages first: they show when the boot was, and so when the others were.
        for (const bool historical : {false, true})
            for (const SensorMessage& message : report.messages)
                if (message.historical == historical) take(message);
        for (const SequenceRange& range : report.lost) boot_.received.give_up(range);
        finish();
        return {std::move(answer_), std::nullopt, as_of(std::move(record_.sensor), now_ms_)};
    }

private:
    void take(const SensorMessage& message) {
        if (!boot_.received.add(message.sequence)) {
            ++answer_.num_repeated;
            return;
        }
        ++answer_.num_new;
        if (!message.historical) place_boot(message.uptime_ms);
        const bool speaks = !message.historical && comes_to_speak();
        switch (message.kind) {
            case MessageKind::Hello:
                if (speaks) record_.sensor.hello = message.body;
                break;
            case MessageKind::Status: {
                const std::int64_t time_ms = time_of(message);
                insert_status(message, time_ms);
                if (speaks && message.sequence > record_.status_sequence) show(message, time_ms);
                break;
            }
            case MessageKind::Preview: {
                const Preview preview = insert_preview(
                    session_, record_.number, message, time_of(message), max_previews_);
                if (speaks) show(preview);
                break;
            }
            case MessageKind::Outcome: end_command(session_, record_, message.body, now_ms_); break;
        }
    }

    // The smallest delay seen gives the best estimate of the boot's time.
    void place_boot(std::int64_t uptime_ms) {
        const std::int64_t epoch_ms = now_ms_ - uptime_ms;
        const bool is_better = !boot_.epoch_ms || epoch_ms < *boot_.epoch_ms ||
                               epoch_ms > *boot_.epoch_ms + kMaxAhead_ms;
        if (is_better) boot_.epoch_ms = epoch_ms;
    }

    // Returns whether this boot speaks for the sensor: it is the last one that began to.
    bool comes_to_speak() {
        if (boot_.life == 0) {
            boot_.life = ++record_.num_lives;
            record_.boot = boot_.number;
            record_.status_sequence = -1;
        }
        const bool speaks = boot_.number == record_.boot;
        if (!speaks) record_.twin_at_ms = now_ms_;
        return speaks;
    }

    std::int64_t time_of(const SensorMessage& message) const {
        if (boot_.epoch_ms) return std::min(now_ms_, *boot_.epoch_ms + message.uptime_ms);
        const bool is_believed = message.time_ms && *message.time_ms <= now_ms_ + kMaxAhead_ms &&
                                 *message.time_ms >= now_ms_ - kMaxBack_ms;
        return is_believed ? std::min(now_ms_, *message.time_ms) : now_ms_;
    }

    void show(const SensorMessage& message, std::int64_t time_ms) {
        Sensor& sensor = record_.sensor;
        sensor.status = message.body;
        sensor.status_at_ms = time_ms;
        record_.status_sequence = message.sequence;
        const auto plan = message.body.find("dive_plan");
        const bool is_planned = plan != message.body.end() && plan->is_object();
        sensor.back_at_ms =
            is_planned
                ? time_ms + static_cast<std::int64_t>(1000.0 * plan->at("back_in_s").get<double>())
                : 0;
        shown_ = true;
    }

    void show(const Preview& preview) {
        auto& previews = record_.sensor.previews;
        const auto shown = previews.find(preview.camera);
        if (shown == previews.end() && previews.size() >= kMaxCameras) return;
        if (shown != previews.end() && shown->second.time_ms > preview.time_ms) return;
        previews[preview.camera] = preview;
        shown_ = true;
    }

    void insert_status(const SensorMessage& message, std::int64_t time_ms) {
        json more = message.body;
        std::array<double, kStatusFields.size()> values{};
        std::array<soci::indicator, kStatusFields.size()> known{};
        std::string names, places;
        for (std::size_t i = 0; i < kStatusFields.size(); ++i) {
            const std::string name(kStatusFields[i].name);
            const auto value = status_value(message.body, kStatusFields[i]);
            values[i] = value.value_or(0.0);
            known[i] = value ? soci::i_ok : soci::i_null;
            names += ", " + name;
            places += ", :" + name;
            more.erase(name);
        }
        const std::string rest = to_text(more);
        fault_point();
        soci::statement statement(session_);
        statement.exchange(soci::use(record_.number, "sensor"));
        statement.exchange(soci::use(time_ms, "time"));
        statement.exchange(soci::use(boot_.number, "boot"));
        statement.exchange(soci::use(message.sequence, "sequence"));
        for (std::size_t i = 0; i < kStatusFields.size(); ++i)
            statement.exchange(soci::use(values[i], known[i], std::string(kStatusFields[i].name)));
        statement.exchange(soci::use(rest, "more"));
        statement.alloc();
        statement.prepare("INSERT INTO sensor_statuses (sensor, time_ms, boot, sequence" + names +
                          ", more) VALUES (:sensor, :time, :boot, :sequence" + places + ", :more)");
        statement.define_and_bind();
        statement.execute(true);
    }

    void finish() {
        Sensor& sensor = record_.sensor;
        sensor.seen_at_ms = now_ms_;
        std::vector<Alarm> alarms =
            shown_ ? alarms_of(newest_word(sensor), sensor.alarms) : sensor.alarms;
        if (!shown_) std::erase_if(alarms, is_ours);
        if (now_ms_ - record_.twin_at_ms < kTwinForgotten_ms)
            alarms.push_back({"twin",
                              Summary::Attention,
                              "two devices use the id \"" + sensor.id +
                                  "\", and the one that connected last is shown: give the other "
                                  "one its own id and token"});
        set_alarms(session_, sensor, std::move(alarms));
        set_state(session_, sensor, SensorState::Online);
        if (boot_.number == record_.boot) {
            sensor.boot_id = boot_.boot_id;
            sensor.received = boot_.received;
        }
        save_boot(session_, record_.number, boot_, now_ms_);
        save_sensor(session_, record_);
        answer_.acknowledged = boot_.received.acknowledged();
        answer_.gaps = first_gaps(boot_.received);
        answer_.num_lost = boot_.received.num_lost();
        answer_.superseded = boot_.number != record_.boot;
    }

    soci::session& session_;
    SensorRecord record_;
    BootRecord boot_;
    std::int64_t now_ms_;
    int max_previews_ = kMaxPreviews;
    SensorAnswer answer_;
    bool shown_ = false;
};

SensorRecord sensor_of(soci::session& session,
                       const IncomingReport& incoming,
                       std::int64_t now_ms) {
    if (auto known = find_sensor(session, incoming.sensor)) return std::move(*known);
    execute(session,
            "INSERT INTO sensors (id, project, state, seen_at_ms, created_at_ms)"
            " VALUES (:id, :project, 'idle', :now, :now)",
            soci::use(incoming.sensor, "id"),
            soci::use(incoming.project, "project"),
            soci::use(now_ms, "now"));
    return find_sensor(session, incoming.sensor).value();
}

BootRecord boot_of(soci::session& session, const SensorRecord& record, const std::string& boot_id) {
    if (auto known = find_boot(session, record.number, boot_id)) return std::move(*known);
    BootRecord boot;
    boot.boot_id = boot_id;
    session << "SELECT COALESCE(MAX(number), 0) + 1 FROM sensor_boots WHERE sensor = :sensor",
        soci::into(boot.number), soci::use(record.number, "sensor");
    const std::int64_t forgotten = boot.number - kMaxBoots;
    execute(session,
            "DELETE FROM sensor_boots WHERE sensor = :sensor AND number <= :forgotten"
            " AND number <> :shown",
            soci::use(record.number, "sensor"),
            soci::use(forgotten, "forgotten"),
            soci::use(record.boot, "shown"));
    return boot;
}

ReportOutcome receive_one(soci::session& session,
                          const IncomingReport& incoming,
                          std::int64_t now_ms,
                          int max_previews) {
    SensorRecord record = sensor_of(session, incoming, now_ms);
    if (record.sensor.project != incoming.project)
        return {{},
                Error(ErrorCode::Conflict,
                      "\"" + incoming.sensor +
                          "\" is a sensor of another project: give this one another id"),
                {}};
    BootRecord boot = boot_of(session, record, incoming.report.boot_id);
    return Receiver(session, std::move(record), std::move(boot), now_ms, max_previews)
        .receive(incoming.report);
}

// Returns whether time has changed the sensor since its last event.
bool is_reportable(const SensorRecord& record, std::int64_t now_ms) {
    const bool has_twin = find_alarm(record.sensor.alarms, "twin") != nullptr;
    return as_of(record.sensor, now_ms).state != record.sensor.state ||
           (has_twin && now_ms - record.twin_at_ms >= kTwinForgotten_ms);
}

Sensor update_by_time(soci::session& session, SensorRecord record, std::int64_t now_ms) {
    Sensor& sensor = record.sensor;
    const SensorState state = as_of(sensor, now_ms).state;
    std::vector<Alarm> alarms = sensor.alarms;
    std::erase_if(alarms, [&](const Alarm& alarm) {
        return alarm.name == "overdue" ||
               (alarm.name == "twin" && now_ms - record.twin_at_ms >= kTwinForgotten_ms);
    });
    if (state == SensorState::Overdue || state == SensorState::Lost)
        alarms.push_back(
            {"overdue", Summary::Stop, "expected back but silent: look for the diver first"});
    set_alarms(session, sensor, std::move(alarms));
    set_state(session, sensor, state);
    save_sensor(session, record);
    return as_of(sensor, now_ms);
}

}  // namespace

std::vector<ReportOutcome> SensorStore::receive(const std::vector<IncomingReport>& reports,
                                                int max_previews) {
    std::vector<ReportOutcome> outcomes;
    catalog_.transaction([&](soci::session& session) {
        outcomes.clear();
        const std::int64_t now_ms = Catalog::now_ms(session);
        for (const IncomingReport& incoming : reports)
            outcomes.push_back(receive_one(session, incoming, now_ms, max_previews));
    });
    return outcomes;
}

Sensor SensorStore::get(const std::string& id) {
    std::optional<Sensor> sensor;
    catalog_.read([&](soci::session& session) {
        if (const auto record = find_sensor(session, id))
            sensor = as_of(record->sensor, Catalog::now_ms(session));
    });
    if (!sensor) throw Error(ErrorCode::NotFound, "no sensor " + id);
    return std::move(*sensor);
}

Page<Sensor> SensorStore::list(const std::string& project, const PageRequest& page) {
    const PageStart start = page_start(page);
    std::vector<Sensor> sensors;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        const auto records =
            select_all<SensorRow>(session,
                                  kSelectSensors +
                                      " WHERE (:project = '' OR project = :project)"
                                      " AND (created_at_ms > :age"
                                      " OR (created_at_ms = :age AND id > :id))"
                                      " ORDER BY created_at_ms, id LIMIT :limit",
                                  soci::use(project, "project"),
                                  soci::use(start.created_at_ms, "age"),
                                  soci::use(start.id, "id"),
                                  soci::use(start.limit_plus_one, "limit"));
        for (const SensorRecord& record : records) sensors.push_back(as_of(record.sensor, now_ms));
    });
    return make_page(std::move(sensors), page);
}

std::vector<Sensor> SensorStore::look_at_the_time() {
    const auto find = [](soci::session& session, std::int64_t now_ms) {
        auto records = select_all<SensorRow>(
            session, kSelectSensors + " WHERE state <> 'idle' OR alarms <> '[]'");
        std::erase_if(records,
                      [&](const SensorRecord& record) { return !is_reportable(record, now_ms); });
        return records;
    };
    bool is_anything = false;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        is_anything = !find(session, now_ms).empty() || has_late_commands(session, now_ms);
    });
    std::vector<Sensor> changed;
    if (!is_anything) return changed;  // avoids an empty write
    catalog_.transaction([&](soci::session& session) {
        changed.clear();
        const std::int64_t now_ms = Catalog::now_ms(session);
        for (SensorRecord& record : find(session, now_ms))
            changed.push_back(update_by_time(session, std::move(record), now_ms));
        end_late_commands(session, now_ms);
    });
    return changed;
}

bool SensorStore::forget_older_than(std::chrono::milliseconds age) {
    long long num_forgotten = 0;
    catalog_.transaction([&](soci::session& session) {
        num_forgotten = 0;
        const std::int64_t before_ms = Catalog::now_ms(session) - age.count();
        for (const std::int64_t number :
             select_all<NumberRow>(session, "SELECT number FROM sensors")) {
            if (num_forgotten >= kForgottenAtOnce) break;
            num_forgotten += execute(
                session,
                "DELETE FROM sensor_statuses WHERE (sensor, time_ms, boot, sequence) IN (SELECT"
                " sensor, time_ms, boot, sequence FROM sensor_statuses WHERE sensor = :sensor"
                " AND time_ms < :before ORDER BY time_ms LIMIT :limit)",
                soci::use(number, "sensor"),
                soci::use(before_ms, "before"),
                soci::use(kForgottenAtOnce, "limit"));
        }
    });
    return num_forgotten < kForgottenAtOnce;
}

}  // namespace divemesh::storage
