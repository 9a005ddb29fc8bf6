#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

namespace divemesh::dive {

// Calls `row` with line number (from 1) and trimmed fields of every line that is no comment, not
// empty, and not a heading in the first place. At most 32 fields a line; the rest is not seen.
void for_each_csv_row(
    std::string_view text,
    const std::function<void(std::int64_t line, std::span<const std::string_view> fields)>& row);

// Nothing unless the whole field is such a number. A double may be "nan" or "inf".
std::optional<std::int64_t> parse_integer(std::string_view field);
std::optional<double> parse_double(std::string_view field);

}  // namespace divemesh::dive
