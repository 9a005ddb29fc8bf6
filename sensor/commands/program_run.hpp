#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace divemesh::sensor {

// A child process, started and supervised without blocking. Its process group is killed when it
// takes longer than `time`, and by the destructor.
class ProgramRun {
public:
    using Clock = std::chrono::steady_clock;

    // Throws Error{Unavailable} if it cannot be started.
    ProgramRun(const std::vector<std::string>& command, std::chrono::milliseconds time);
    ~ProgramRun();
    ProgramRun(const ProgramRun&) = delete;
    ProgramRun& operator=(const ProgramRun&) = delete;

    // Returns nullopt while it runs; then "" if it exited with 0, otherwise a description of how it
    // ended.
    std::optional<std::string> poll();

private:
    void kill_group();

    pid_t pid_ = -1;  // -1: it has ended
    Clock::time_point until_;
};

}  // namespace divemesh::sensor
