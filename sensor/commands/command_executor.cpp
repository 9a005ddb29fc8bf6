#include "sensor/commands/command_executor.hpp"

#include <algorithm>
#include <ctime>
#include <system_error>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

constexpr std::size_t kMaxWaiting = 64;
constexpr std::size_t kMaxDetailBytes = 200;

bool is_recording_command(const std::string& name) {
    return name == "start_recording" || name == "stop_recording";
}

}  // namespace

CommandExecutor::CommandExecutor(CommandSettings settings)
    : settings_(std::move(settings)), journal_(settings_.journal) {}

std::vector<std::string> CommandExecutor::capabilities() const {
    std::vector<std::string> names;
    for (const char* name : {"preview", "start_recording", "stop_recording", "set_clock"})
        if (is_able(name)) names.emplace_back(name);
    return names;
}

bool CommandExecutor::is_able(const std::string& name) const {
    if (is_recording_command(name)) return !settings_.on_command.empty();
    return name == "preview" || (name == "set_clock" && settings_.allow_set_clock);
}

// Uses the latest possible time of the server.
bool CommandExecutor::is_late(const Command& command) const {
    return command.server_time.latest_ms(settings_.uptime_ms()) >= command.expires_at_ms;
}

void CommandExecutor::take(const Command& command) {
    const auto is_it = [&](const Command& other) { return other.id == command.id; };
    const bool is_under_way =
        running_id_ == command.id || std::any_of(waiting_.begin(), waiting_.end(), is_it);
    if (is_under_way || waiting_.size() >= kMaxWaiting) return;
    const auto known = journal_.find(command.id);
    if (!known) return waiting_.push_back(command);
    if (known->state == "begun")
        return end(command.id, "failed", "the device restarted while it carried out the command");
    outcomes_.push_back(
        {{"command", known->id}, {"state", known->state}, {"detail", known->detail}});
}

std::vector<nlohmann::json> CommandExecutor::work() {
    if (running_) {
        if (const auto how = running_->poll()) {
            end(std::exchange(running_id_, ""), how->empty() ? "done" : "failed", *how);
            running_.reset();
        }
    }
    while (!running_ && !waiting_.empty()) {
        const Command command = std::move(waiting_.front());
        waiting_.pop_front();
        begin(command);
    }
    return std::exchange(outcomes_, {});
}

void CommandExecutor::begin(const Command& command) {
    if (!is_able(command.name))
        return end(command.id, "refused", "this device does not support " + command.name);
    if (is_late(command)) return end(command.id, "expired", "the command arrived too late");
    if (!journal_.note({command.id, "begun", ""}) && command.name != "preview")
        return end(command.id,
                   "failed",
                   "the command cannot be recorded on disk and might be carried out twice");
    // Writing the note took time, so check again.
    if (is_late(command)) return end(command.id, "expired", "the command arrived too late");
    if (is_recording_command(command.name)) return run_program(command);
    const std::string problem =
        command.name == "preview" ? settings_.make_preview(command.arguments) : set_clock(command);
    end(command.id, problem.empty() ? "done" : "failed", problem);
}

void CommandExecutor::run_program(const Command& command) {
    try {
        running_ = std::make_unique<ProgramRun>(
            std::vector<std::string>{settings_.on_command.string(), command.name},
            settings_.program_time);
        running_id_ = command.id;
    } catch (const Error& error) {
        end(command.id, "failed", error.what());
    }
}

// Sets the requested time plus the time since the command arrived.
std::string CommandExecutor::set_clock(const Command& command) const {
    const auto time = command.arguments.find("time_ms");
    if (time == command.arguments.end() || !time->is_number_integer())
        return "\"time_ms\" is missing";
    return settings_.set_clock(time->get<std::int64_t>() + settings_.uptime_ms() -
                               command.came_at_uptime_ms);
}

void CommandExecutor::end(const std::string& id,
                          const std::string& state,
                          const std::string& detail) {
    const std::string told = detail.substr(0, kMaxDetailBytes);
    journal_.note({id, state, told});
    outcomes_.push_back({{"command", id}, {"state", state}});
    if (!told.empty()) outcomes_.back()["detail"] = told;
}

std::string set_machine_clock(std::int64_t time_ms) {
    const timespec time{time_ms / 1000, time_ms % 1000 * 1'000'000};
    if (::clock_settime(CLOCK_REALTIME, &time) == 0) return "";
    return std::generic_category().message(errno);
}

}  // namespace divemesh::sensor
