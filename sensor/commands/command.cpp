#include "sensor/commands/command.hpp"

#include "sensor/clock/uptime.hpp"

namespace divemesh::sensor {

std::optional<Command> command_of(const nlohmann::json& json) {
    constexpr std::size_t kMaxIdBytes = 256;
    try {
        Command command;
        json.at("id").get_to(command.id);
        json.at("name").get_to(command.name);
        json.at("expires_at_ms").get_to(command.expires_at_ms);
        if (json.contains("arguments") && json["arguments"].is_object())
            command.arguments = json["arguments"];
        command.came_at_uptime_ms = uptime_ms();
        if (command.id.empty() || command.id.size() > kMaxIdBytes) return std::nullopt;
        return command;
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

}  // namespace divemesh::sensor
