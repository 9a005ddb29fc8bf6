#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace divemesh {

// The state of a command to a device. Only declared here.
//
//   pending  the device has not fetched it yet
//   sent     sent to the device, which has not reported an outcome
//   done     carried out
//   failed   the device tried without success
//   refused  the device does not support it
//   expired  too late: not sent in time, or sent without an outcome
//
// The device's outcome is final, even if the server had marked the command as expired.
enum class CommandState { Pending, Sent, Done, Failed, Refused, Expired };
std::string_view to_string(CommandState state);
CommandState command_state_from_string(std::string_view text);

// A command to a device. Times are unix milliseconds of the catalog's clock.
struct SensorCommand {
    std::string id;
    std::string sensor;
    std::string name;
    nlohmann::json arguments = nlohmann::json::object();
    CommandState state = CommandState::Pending;
    std::string detail;        // of the outcome, for users
    std::string requested_by;  // id of the token; "": without one
    std::int64_t created_at_ms = 0;
    std::int64_t expires_at_ms = 0;
    std::int64_t sent_at_ms = 0;   // 0: not yet
    std::int64_t ended_at_ms = 0;  // 0: not yet
};

inline constexpr std::int64_t kMinCommandLife_ms = 1'000;
inline constexpr std::int64_t kMaxCommandLife_ms = 86'400'000;

// Throws InvalidInput for an unknown command and for invalid arguments.
void check_command(const std::string& name, const nlohmann::json& arguments);

// Returns the arguments to send at `now_ms` of the catalog's clock. For set_clock these contain the
// current time, by the requester's clock (time_ms at the time of the request) or by the catalog's.
nlohmann::json arguments_at(const SensorCommand& command, std::int64_t now_ms);

// Checks a device's outcome of a command, {"command": ID, "state": ..., "detail": ...}. Throws
// InvalidInput with the fault's place below `pointer`.
void check_outcome(const nlohmann::json& outcome, const std::string& pointer);

void to_json(nlohmann::json& json, const SensorCommand& command);

}  // namespace divemesh
