#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

#include "tests/end_to_end/process.hpp"

namespace divemesh {

// `divemesh serve` without workers on a free port of loopback, as a process of its own.
class Served {
public:
    // Throws std::runtime_error with what it said when it does not come up.
    Served(const std::filesystem::path& program, const std::filesystem::path& data);

    const std::string& address() const { return address_; }
    int port() const { return std::stoi(address_.substr(address_.rfind(':') + 1)); }
    pid_t pid() const { return process_.pid(); }
    // When requests of the path were answered so far, unix milliseconds.
    std::vector<std::int64_t> times_of(const std::string& path) const;

private:
    Process process_;
    std::string address_;
};

}  // namespace divemesh
