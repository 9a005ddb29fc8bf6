#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace divemesh {

// A program that was started, its output in files; killed with the object when it still runs.
class Process {
public:
    using Environment = std::map<std::string, std::string>;  // beside what the test itself has

    Process(const std::vector<std::string>& command,
            const std::filesystem::path& output_folder,
            const Environment& environment = {});
    ~Process();
    Process(Process&& other) noexcept;
    Process& operator=(Process&&) = delete;

    // The exit code, 128 + signal when it was killed; nothing when it still runs at the end.
    std::optional<int> wait(std::chrono::seconds timeout);
    void send(int signal);
    void kill();  // SIGKILL, and waits

    pid_t pid() const { return pid_; }
    std::string stdout_text() const;
    std::string stderr_text() const;

private:
    pid_t pid_ = -1;
    std::optional<int> exit_code_;
    std::filesystem::path stdout_file_;
    std::filesystem::path stderr_file_;
};

// Looks every 20 ms until `done()` is true; false when it never was.
template <typename Done>
bool wait_until(std::chrono::seconds timeout, Done&& done);

std::string read_text(const std::filesystem::path& file);  // "" when it is not there
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
