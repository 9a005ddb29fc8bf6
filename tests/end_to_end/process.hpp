#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace divemesh {

// A child process with its output in files. The destructor kills it if it still runs.
class Process {
public:
    using Environment = std::map<std::string, std::string>;  // added to this process's own

    Process(const std::vector<std::string>& command,
            const std::filesystem::path& output_folder,
            const Environment& environment = {});
    ~Process();
    Process(Process&& other) noexcept;
    Process& operator=(Process&&) = delete;

    // Returns the exit code, or 128 + signal if a signal ended it; nullopt if it still runs after
    // the timeout.
    std::optional<int> wait(std::chrono::seconds timeout);
    void send(int signal);
    void kill();  // sends SIGKILL and waits

    pid_t pid() const { return pid_; }
    std::string stdout_text() const;
    std::string stderr_text() const;

private:
    pid_t pid_ = -1;
    std::optional<int> exit_code_;
    std::filesystem::path stdout_file_;
    std::filesystem::path stderr_file_;
};

// Calls `done` every 20 ms until it returns true; returns false after the timeout.
template <typename Done>
bool wait_until(std::chrono::seconds timeout, Done&& done);

std::string read_text(const std::filesystem::path& file);  // "" if the file is missing
void pause_20_ms();

template <typename Done>
bool wait_until(std::chrono::seconds timeout, Done&& done) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) return false;
        pause_20_ms();
    }
    return true;
}

}  // namespace divemesh
