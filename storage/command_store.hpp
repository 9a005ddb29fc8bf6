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

// A new command to a device.
struct CommandRequest {
    std::string sensor;
    std::string name;
    nlohmann::json arguments = nlohmann::json::object();
    std::int64_t life_ms = 0;
    std::string requested_by;  // id of a token; "": without authentication
};

// Commands to devices and their outcomes. Each change is an event of its sensor.
class CommandStore {
public:
    explicit CommandStore(Catalog& catalog) : catalog_(catalog) {}

    // Throws Error{NotFound} for an unknown sensor, Error{Conflict} if its hello does not name the
    // command, Error{TooMany} if the sensor has not fetched the earlier ones.
    SensorCommand create(const CommandRequest& request);
    Page<SensorCommand> list(const std::string& sensor, const PageRequest& page);
    // Throws Error{NotFound}.
    SensorCommand get(const std::string& sensor, const std::string& id);

    // Returns the commands to send to the sensor now, oldest first, and marks them as sent.
    // `again`: also those that were sent before but not answered, for a sensor that has
    // reconnected.
    std::vector<SensorCommand> take(const std::string& sensor, bool again);

private:
    Catalog& catalog_;
};

// Records the outcome of a command as its sensor reports it; changes no command of another sensor.
void end_command(soci::session& session,
                 const SensorRecord& sensor,
                 const nlohmann::json& outcome,
                 std::int64_t now_ms);

// Find and end the commands whose time is over.
bool has_late_commands(soci::session& session, std::int64_t now_ms);
void end_late_commands(soci::session& session, std::int64_t now_ms);

}  // namespace divemesh::storage
