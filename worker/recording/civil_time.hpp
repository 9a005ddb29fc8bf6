#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace divemesh::recording {

// Returns nanoseconds since 1970 of a date and time, read as UTC: "2011-09-26 13:02:25.594360375",
// EXIF's "2011:09:26 13:02:25", with T for the blank and Z behind. nullopt if it is no such text,
// or before 1970 or after 2096.
std::optional<std::int64_t> parse_civil_time(std::string_view text);

// Returns the fraction of a second that digits behind a decimal point state, in nanoseconds;
// nullopt unless all are digits, of which there is one at least.
std::optional<std::int64_t> parse_fraction_ns(std::string_view digits);

// Returns by how much a zone's time is ahead of UTC, of "+02:00", "-09:30" or "Z".
std::optional<std::int64_t> parse_zone_ns(std::string_view text);

}  // namespace divemesh::recording
