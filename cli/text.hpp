#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace divemesh::cli {

std::string bytes_text(double bytes);         // 12.3 MB
std::string duration_text(double seconds);    // 0:42, 12:05, 1:02:03
std::string time_text(std::int64_t unix_ms);  // 2026-11-20 14:03:05, local time; "-" for 0

// Returns a text table: columns as wide as their longest cell, two blanks between them.
std::string table_text(const std::vector<std::vector<std::string>>& rows);

}  // namespace divemesh::cli
