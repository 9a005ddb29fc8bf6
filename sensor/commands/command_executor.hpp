#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sensor/commands/command.hpp"
#include "sensor/commands/command_journal.hpp"
#include "sensor/commands/program_run.hpp"

namespace divemesh::sensor {

struct CommandSettings {
    std::filesystem::path journal;     // file that stores the last commands
    std::filesystem::path on_command;  // program that starts and stops recording; "": not supported
    std::chrono::milliseconds program_time{30'000};
    bool allow_set_clock = false;
    // Makes the preview that `arguments` request; returns "" or why there is none.
    std::function<std::string(const nlohmann::json& arguments)> make_preview;
    std::function<std::int64_t()> uptime_ms;
    std::function<std::string(std::int64_t time_ms)> set_clock;  // returns "" or why it failed
};

// Carries out the commands to the device: each command once, however often it arrives, and none
// after its expiry by the server's clock. Use it from one thread at a time.
class CommandExecutor {
public:
    explicit CommandExecutor(CommandSettings settings);

    std::vector<std::string> capabilities() const;
    void take(const Command& command);
    // Continues with the taken commands and returns outcomes, as the bodies of outcome messages.
    std::vector<nlohmann::json> work();

private:
    bool is_able(const std::string& name) const;
    bool is_late(const Command& command) const;
    void begin(const Command& command);
    void run_program(const Command& command);
    std::string set_clock(const Command& command) const;
    void end(const std::string& id, const std::string& state, const std::string& detail);

    CommandSettings settings_;
    CommandJournal journal_;
    std::deque<Command> waiting_;
    std::string running_id_;  // "": no program runs
    std::unique_ptr<ProgramRun> running_;
    std::vector<nlohmann::json> outcomes_;
};

// Sets the machine's clock; the implementation for CommandSettings::set_clock.
std::string set_machine_clock(std::int64_t time_ms);

}  // namespace divemesh::sensor
