#pragma once

#include <filesystem>
#include <string>
#include <sys/types.h>

namespace divemesh::cli {

// A server of this program in a process of its own: on a free port of loopback, with one worker. It
// ends with this process, however this one ends. DIVEMESH_* variables and the config file have no
// effect on it.
class ServerProcess {
public:
    // Starts it with its log appended to `log`, and waits until it listens. Throws
    // Error{Unavailable}, naming the log, if it does not.
    ServerProcess(const std::filesystem::path& data, const std::filesystem::path& log);
    ~ServerProcess();  // asks it to stop and waits until it has
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    const std::string& url() const { return url_; }
    void wait();  // until it has ended

private:
    pid_t pid_ = -1;
    std::string url_;
};

}  // namespace divemesh::cli
