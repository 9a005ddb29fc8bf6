#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

namespace divemesh::dive {

// Calls `row` with the line number (from 1) and the fields of every line, trimmed and without
// quotes around them, except comments, empty lines and a heading at the start. A quoted field holds
// no comma. Reads at most 32 fields a line; further ones are ignored.
void for_each_csv_row(
    std::string_view text,
    const std::function<void(std::int64_t line, std::span<const std::string_view> fields)>& row);

// Return nullopt unless the whole field is such a number. A double may be "nan" or "inf".
std::optional<std::int64_t> parse_integer(std::string_view field);
std::optional<double> parse_double(std::string_view field);

}  // namespace divemesh::dive
