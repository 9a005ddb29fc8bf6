#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "sensor/clock/server_time.hpp"

namespace divemesh::sensor {

// A command to the device.
struct Command {
    std::string id;
    std::string name;
    nlohmann::json arguments = nlohmann::json::object();
    std::int64_t expires_at_ms = 0;  // by the server's clock
    ServerTime server_time;          // of the stream that it arrived by
    std::int64_t came_at_uptime_ms = 0;
};

// Parses the JSON object of a frame; nullopt if it is not a command.
std::optional<Command> command_of(const nlohmann::json& json);

}  // namespace divemesh::sensor
