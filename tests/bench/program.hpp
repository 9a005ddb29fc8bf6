#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::bench {

// Runs a program to its end and gives its exit code; what it prints goes to `log`, its errors too
// unless `errors_apart`.
int run_program(std::vector<std::string> words,
                const std::filesystem::path& log,
                bool errors_apart = false);

std::string last_lines(const std::filesystem::path& log);

}  // namespace divemesh::bench
