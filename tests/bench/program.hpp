#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::bench {

// Runs a program to its end and gives its exit code; what it prints goes to `log`, its errors too
// unless `errors_apart`.
int run_program(std::vector<std::string> words,
                const std::filesystem::path& log,
                bool errors_apart = false);

struct ProgramUsage {
    int exit_code = 0;
    double wall_s = 0.0;
    double cpu_s = 0.0;  // user and system
    // Not less than this process had when it started the program: Linux counts that in.
    std::int64_t peak_memory_bytes = 0;
};

// The same, with its output and errors in one, and what it took.
ProgramUsage run_measured(std::vector<std::string> words, const std::filesystem::path& log);

std::string last_lines(const std::filesystem::path& log);

}  // namespace divemesh::bench
