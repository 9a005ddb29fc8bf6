#pragma once

#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

namespace divemesh {

// A server as a process of its own, over the same data folder each time; killed at the end. `more`:
// what serve_process takes after the folder.
class ServerProcess {
public:
    explicit ServerProcess(const std::filesystem::path& data,
                           const std::vector<std::string>& more = {});
    ~ServerProcess();
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    int port() const { return port_; }
    void send(int signal) const;
    int end(int signal);  // its exit code; 128 and the signal that ended it; -1: ended before

private:
    pid_t pid_ = -1;
    int port_ = 0;
};

// The token that the server made when it first started in this folder.
std::string read_token(const std::filesystem::path& data);

}  // namespace divemesh
