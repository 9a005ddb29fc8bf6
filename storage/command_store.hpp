#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "schemas/sensor_command.hpp"
#include "storage/catalog.hpp"
#include "storage/page.hpp"
#include "storage/sensor_rows.hpp"

namespace divemesh::storage {

// What is asked of a device.
struct CommandRequest {
    std::string sensor;
    std::string name;
    nlohmann::json arguments = nlohmann::json::object();
    std::int64_t life_ms = 0;
    std::string requested_by;  // id of a token; "": nobody's
};

// Commands to devices and what became of them. Each change is an event of its sensor.
class CommandStore {
public:
    explicit CommandStore(Catalog& catalog) : catalog_(catalog) {}

    // Throws Error{NotFound} for the sensor, Error{Conflict} when its hello does not name the
    // command, Error{TooMany} when it has not come for the ones before.
    SensorCommand create(const CommandRequest& request);
    Page<SensorCommand> list(const std::string& sensor, const PageRequest& page);
    // Throws Error{NotFound}.
    SensorCommand get(const std::string& sensor, const std::string& id);

    // What is to be handed to the sensor now, first asked first; it counts as sent from here on.
    // `again`: also what was sent before and is not answered, for a sensor that has come anew.
    std::vector<SensorCommand> take(const std::string& sensor, bool again);

private:
    Catalog& catalog_;
};

// What the sensor says became of a command of its own; of others nothing is changed.
void end_command(soci::session& session,
                 const SensorRecord& sensor,
                 const nlohmann::json& outcome,
                 std::int64_t now_ms);

// Those whose time is over.
bool has_late_commands(soci::session& session, std::int64_t now_ms);
void end_late_commands(soci::session& session, std::int64_t now_ms);

}  // namespace divemesh::storage
