#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "schemas/file_descriptor.hpp"

namespace divemesh::runner {

// Limits that the kernel enforces on a child; 0: no limit.
struct ProcessLimits {
    // RLIMIT_DATA: private writable memory, not mapped files
    std::int64_t max_memory_bytes = 0;
    std::int64_t max_file_bytes = 0;  // RLIMIT_FSIZE, of one file
    std::int64_t max_open_files = 0;  // RLIMIT_NOFILE
    std::int64_t max_cpu_s = 0;       // RLIMIT_CPU, of all threads
    bool no_network = false;          // run in an empty network namespace
};

// Returns whether this machine allows a child to be started without network: root may, others if
// user namespaces are allowed (containers often forbid them).
bool can_cut_network();

// How a child ended: with an exit code or by a signal.
struct ProcessEnd {
    int exit_code = 0;
    int signal = 0;  // 0: it exited
};

// A child in its own process group, with a pipe from its descriptor kAttemptPipe to this process.
// It dies with the thread that started it (PR_SET_PDEATHSIG). The destructor kills the group and
// reaps it.
class ChildProcess {
public:
    // Throws Error{Unavailable} if the child cannot be started.
    ChildProcess(const std::vector<std::string>& command, const ProcessLimits& limits);
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    pid_t pid() const { return pid_; }
    void signal_group(int signal) const;  // not allowed after poll_end() has returned a value

    // Appends what arrives over the pipe within the timeout. Returns false if the other end is
    // closed.
    bool read_some(std::string& buffer, int timeout_ms);
    // Returns nullopt while the child runs. Once it has ended, all processes that it started have
    // ended too.
    std::optional<ProcessEnd> poll_end();

private:
    pid_t pid_ = -1;
    FileDescriptor pipe_;  // our end
    std::optional<ProcessEnd> end_;
};

}  // namespace divemesh::runner
