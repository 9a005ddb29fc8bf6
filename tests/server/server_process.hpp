#pragma once

#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

namespace divemesh {

// A server process over a data folder; the destructor kills it. `more` holds the arguments of
// serve_process after the folder.
class ServerProcess {
public:
    explicit ServerProcess(const std::filesystem::path& data,
                           const std::vector<std::string>& more = {});
    ~ServerProcess();
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    int port() const { return port_; }
    void send(int signal) const;
    int end(int signal);  // returns the exit code; 128 + signal; -1 if it ended before

private:
    pid_t pid_ = -1;
    int port_ = 0;
};

// Returns the token that the server made when it first started in this folder.
std::string read_token(const std::filesystem::path& data);

}  // namespace divemesh
