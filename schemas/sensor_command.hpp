#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace divemesh {

// Where a command to a device is. The only place where that is declared.
//
//   pending  the device has not come for it yet
//   sent     handed to the device, which has not said what became of it
//   done     carried out
//   failed   the device tried and could not
//   refused  the device does not do that
//   expired  too late: not carried out, or handed over and never answered
//
// What the device says is the last word, also after the server took it for expired.
enum class CommandState { Pending, Sent, Done, Failed, Refused, Expired };
std::string_view to_string(CommandState state);
CommandState command_state_from_string(std::string_view text);

// Something that a device is asked to do. Times are unix milliseconds of the catalog's clock.
struct SensorCommand {
    std::string id;
    std::string sensor;
    std::string name;
    nlohmann::json arguments = nlohmann::json::object();
    CommandState state = CommandState::Pending;
    std::string detail;        // of the outcome, for people
    std::string requested_by;  // id of the token; "": without one
    std::int64_t created_at_ms = 0;
    std::int64_t expires_at_ms = 0;
    std::int64_t sent_at_ms = 0;   // 0: not yet
    std::int64_t ended_at_ms = 0;  // 0: not yet
};

inline constexpr std::int64_t kMinCommandLife_ms = 1'000;
inline constexpr std::int64_t kMaxCommandLife_ms = 86'400'000;

// Throws InvalidInput for a command that no device knows and arguments that it does not have.
void check_command(const std::string& name, const nlohmann::json& arguments);

// The arguments as they are handed over at `now_ms` of the catalog's clock: set_clock with the time
// that it is then, by the clock of whoever asked (time_ms when it was asked for) or by ours.
nlohmann::json arguments_at(const SensorCommand& command, std::int64_t now_ms);

// What a device says became of a command, {"command": ID, "state": ..., "detail": ...}. Throws
// InvalidInput that says where below `pointer` it is wrong.
void check_outcome(const nlohmann::json& outcome, const std::string& pointer);

void to_json(nlohmann::json& json, const SensorCommand& command);

}  // namespace divemesh
