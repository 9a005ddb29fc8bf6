#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

#include "tests/end_to_end/process.hpp"

namespace divemesh {

// A process of `divemesh serve` without workers, on a free port of loopback.
class Served {
public:
    // Throws std::runtime_error with the server's stderr if it does not start.
    Served(const std::filesystem::path& program,
           const std::filesystem::path& data,
           const std::vector<std::string>& options = {},
           const Process::Environment& environment = {});

    const std::string& address() const { return address_; }
    int port() const { return std::stoi(address_.substr(address_.rfind(':') + 1)); }
    pid_t pid() const { return process_.pid(); }
    // Returns when requests of this path were answered until now, Unix time in ms.
    std::vector<std::int64_t> times_of(const std::string& path) const;

private:
    Process process_;
    std::string address_;
};

}  // namespace divemesh
