#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/end_to_end/process.hpp"

namespace divemesh {

// `divemesh serve` without workers on a free port of loopback, as a process of its own.
class Served {
public:
    // Throws std::runtime_error with what it said when it does not come up.
    Served(const std::filesystem::path& program, const std::filesystem::path& data);

    const std::string& address() const { return address_; }
    int port() const { return std::stoi(address_.substr(address_.rfind(':') + 1)); }
    std::int64_t peak_memory_bytes() const;  // VmHWM; -1: not known
    double cpu_seconds() const;              // user and system so far

private:
    Process process_;
    std::string address_;
};

}  // namespace divemesh
