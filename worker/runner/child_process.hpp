#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "schemas/file_descriptor.hpp"

namespace divemesh::runner {

// Limits that the kernel holds a child to; 0: none.
struct ProcessLimits {
    std::int64_t max_memory_bytes = 0;  // RLIMIT_DATA: what it may write to, not what it maps
    std::int64_t max_file_bytes = 0;    // RLIMIT_FSIZE, of one file
    std::int64_t max_open_files = 0;    // RLIMIT_NOFILE
    std::int64_t max_cpu_s = 0;         // RLIMIT_CPU, of all threads
    bool no_network = false;            // a network namespace of its own, with nothing in it
};

// Whether this machine lets us start a child without network: root may, others where user
// namespaces are allowed (containers often forbid them).
bool can_cut_network();

// How a child ended: by exit code or by signal.
struct ProcessEnd {
    int exit_code = 0;
    int signal = 0;  // 0: it exited
};

// A child in its own process group, with a pipe from its descriptor kAttemptPipe to us. It dies
// with the thread that started it (PR_SET_PDEATHSIG). The destructor kills the group and reaps.
class ChildProcess {
public:
    // Throws Error{Unavailable} when it cannot be started.
    ChildProcess(const std::vector<std::string>& command, const ProcessLimits& limits);
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    pid_t pid() const { return pid_; }
    void signal_group(int signal) const;  // not after poll_end() has said how it ended

    // Appends what came over the pipe within the timeout; false: the other end is closed.
    bool read_some(std::string& buffer, int timeout_ms);
    // Nothing while it runs. Once it has ended, so has all that it started.
    std::optional<ProcessEnd> poll_end();

private:
    pid_t pid_ = -1;
    FileDescriptor pipe_;  // our end
    std::optional<ProcessEnd> end_;
};

}  // namespace divemesh::runner
