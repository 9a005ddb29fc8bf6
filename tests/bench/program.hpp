#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::bench {

// Runs a program and returns its exit code: 127 if it cannot be started, 128 if a signal ends it.
// Writes its stdout to `log`, and its stderr too unless `errors_apart` is set.
int run_program(std::vector<std::string> words,
                const std::filesystem::path& log,
                bool errors_apart = false);

struct ProgramUsage {
    int exit_code = 0;
    double wall_s = 0.0;
    double cpu_s = 0.0;  // user and system
    // At least the memory of this process when it started the program: Linux includes it.
    std::int64_t peak_memory_bytes = 0;
};

// Runs a program with stdout and stderr in `log`. Returns its exit code, time and peak memory.
ProgramUsage run_measured(std::vector<std::string> words, const std::filesystem::path& log);

// Returns the last 600 bytes of a log.
std::string last_lines(const std::filesystem::path& log);

}  // namespace divemesh::bench
