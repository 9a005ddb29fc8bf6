#include "schemas/sensor_command.hpp"

#include <algorithm>
#include <span>

#include "schemas/enum_text.hpp"
#include "schemas/invalid_input.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

constexpr EnumText<CommandState> kStates[] = {{CommandState::Pending, "pending"},
                                              {CommandState::Sent, "sent"},
                                              {CommandState::Done, "done"},
                                              {CommandState::Failed, "failed"},
                                              {CommandState::Refused, "refused"},
                                              {CommandState::Expired, "expired"}};
// The outcomes that a device may report.
constexpr auto kOutcomes = std::span(kStates).subspan(2);
constexpr std::size_t kMaxDetailBytes = 256;
constexpr std::size_t kMaxCameraBytes = 16;
constexpr std::int64_t kMinImageBytes = 1024;
constexpr std::int64_t kMaxImageBytes = 256 << 10;
constexpr std::int64_t kMaxTime_ms = std::int64_t{1} << 53;

bool is_whole(const json& value, std::int64_t min, std::int64_t max) {
    return value.is_number_unsigned() &&
           value.get<std::uint64_t>() <= static_cast<std::uint64_t>(max) &&
           value.get<std::int64_t>() >= min;
}

bool is_short_text(const json& value, std::size_t max_num_bytes) {
    return value.is_string() && value.get_ref<const std::string&>().size() <= max_num_bytes;
}

struct Argument {
    std::string_view command;
    std::string_view name;
    std::string_view form;
    bool (*fits)(const json& value);
};

constexpr std::string_view kCommands[] = {
    "start_recording", "stop_recording", "preview", "set_clock"};
constexpr Argument kArguments[] = {
    {"preview",
     "camera",
     "the name of a camera",
     [](const json& value) { return is_short_text(value, kMaxCameraBytes); }},
    {"preview",
     "max_bytes",
     "a whole number from 1024 to 262144",
     [](const json& value) { return is_whole(value, kMinImageBytes, kMaxImageBytes); }},
    {"set_clock",
     "time_ms",
     "a time in Unix milliseconds",
     [](const json& value) { return is_whole(value, 0, kMaxTime_ms); }},
};

const Argument* find_argument(std::string_view command, std::string_view name) {
    for (const Argument& argument : kArguments)
        if (argument.command == command && argument.name == name) return &argument;
    return nullptr;
}

}  // namespace

std::string_view to_string(CommandState state) { return enum_to_text(kStates, state); }
CommandState command_state_from_string(std::string_view text) {
    return enum_from_text<CommandState>(kStates, text, "command state");
}

void check_command(const std::string& name, const json& arguments) {
    if (std::find(std::begin(kCommands), std::end(kCommands), name) == std::end(kCommands))
        throw InvalidInput(
            {{"\"name\" must be start_recording, stop_recording, preview or set_clock",
              "/name",
              ""}});
    if (!arguments.is_object())
        throw InvalidInput({{"\"arguments\" must be an object", "/arguments", ""}});
    std::vector<Fault> faults;
    for (const auto& [key, value] : arguments.items()) {
        const Argument* argument = find_argument(name, key);
        const std::string place = "/arguments" + (json::json_pointer() / key).to_string();
        if (argument == nullptr)
            faults.push_back(
                {std::string(name).append(" has no argument \"").append(key) + "\"", place, ""});
        else if (!argument->fits(value))
            faults.push_back({std::string("it must be ").append(argument->form), place, ""});
    }
    if (!faults.empty()) throw InvalidInput(std::move(faults));
}

json arguments_at(const SensorCommand& command, std::int64_t now_ms) {
    json arguments = command.arguments;
    if (command.name != "set_clock") return arguments;
    const std::int64_t asked_ms = arguments.value("time_ms", command.created_at_ms);
    arguments["time_ms"] = asked_ms + now_ms - command.created_at_ms;
    return arguments;
}

void check_outcome(const json& outcome, const std::string& pointer) {
    const auto id = outcome.find("command");
    const auto state = outcome.find("state");
    const auto detail = outcome.find("detail");
    if (id == outcome.end() || !is_short_text(*id, kMaxDetailBytes))
        throw InvalidInput({{"\"command\" must be the id of a command", pointer + "/command", ""}});
    const auto is_state = [&](const auto& row) { return *state == json(row.text); };
    if (state == outcome.end() || std::none_of(kOutcomes.begin(), kOutcomes.end(), is_state))
        throw InvalidInput(
            {{"\"state\" must be done, failed, refused or expired", pointer + "/state", ""}});
    if (detail != outcome.end() && !is_short_text(*detail, kMaxDetailBytes))
        throw InvalidInput(
            {{"\"detail\" must be a text of at most 256 bytes", pointer + "/detail", ""}});
}

void to_json(json& json, const SensorCommand& command) {
    json = {{"id", command.id},
            {"sensor", command.sensor},
            {"name", command.name},
            {"arguments", command.arguments},
            {"state", to_string(command.state)},
            {"detail", command.detail},
            {"requested_by", command.requested_by},
            {"created_at_ms", command.created_at_ms},
            {"expires_at_ms", command.expires_at_ms},
            {"sent_at_ms", command.sent_at_ms},
            {"ended_at_ms", command.ended_at_ms}};
}

}  // namespace divemesh
