#pragma once

#include <optional>
#include <soci/soci.h>
#include <string>

#include "schemas/sensor.hpp"

namespace divemesh::storage {

// A row of sensors, with what was received of its current boot.
struct SensorRecord {
    Sensor sensor;  // as last written: state, age and staleness are not current
    std::int64_t number = 0;
    std::int64_t boot = 0;
    std::int64_t num_lives = 0;
    std::int64_t status_sequence = -1;
    std::int64_t twin_at_ms = 0;
};

struct SensorRow {
    SensorRecord record;
    std::string state, alarms, hello, status, previews, received;

    void define(soci::statement& statement);
    SensorRecord value() const;
};

// The SELECT of a SensorRow, without a WHERE.
extern const std::string kSelectSensors;

std::optional<SensorRecord> find_sensor(soci::session& session, const std::string& id);

// One boot of a sensor.
struct BootRecord {
    std::int64_t number = 0;
    std::string boot_id;
    std::int64_t life = 0;
    std::optional<std::int64_t> epoch_ms;
    SequenceRanges received;
};

std::optional<BootRecord> find_boot(soci::session& session,
                                    std::int64_t sensor,
                                    const std::string& boot_id);
// Inserts the row of a new boot, or updates an existing one.
void save_boot(soci::session& session,
               std::int64_t sensor,
               const BootRecord& boot,
               std::int64_t now_ms);
void save_sensor(soci::session& session, const SensorRecord& record);

}  // namespace divemesh::storage
