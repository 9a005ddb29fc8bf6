#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace divemesh::sensor {

// Another program, started and looked after without waiting for it. Its group is killed when it
// takes longer than it may, and with the object.
class ProgramRun {
public:
    using Clock = std::chrono::steady_clock;

    // Throws Error{Unavailable} when it cannot be started.
    ProgramRun(const std::vector<std::string>& command, std::chrono::milliseconds time);
    ~ProgramRun();
    ProgramRun(const ProgramRun&) = delete;
    ProgramRun& operator=(const ProgramRun&) = delete;

    // Nothing while it runs; then "" if it ended with 0, else how it ended, for people.
    std::optional<std::string> poll();

private:
    void kill_group();

    pid_t pid_ = -1;  // -1: it has ended
    Clock::time_point until_;
};

}  // namespace divemesh::sensor
