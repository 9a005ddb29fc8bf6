#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace divemesh::recording {

// What a number that stands for a time counts.
enum class StampUnit { Nanoseconds, Microseconds, Milliseconds, Seconds };

// Returns the unit of "ns", "us", "ms" or "s"; nullopt for any other text.
std::optional<StampUnit> unit_by_name(std::string_view name);
// Returns "nanoseconds" and so on.
const char* name_of(StampUnit unit);

// Returns the nanoseconds that a number stands for, exact to the last digit: "1403636580.838555" s.
// nullopt if it is no such number, negative or after 2096.
std::optional<std::int64_t> parse_stamp(std::string_view text, StampUnit unit);

// Returns the unit in which all numbers are times: seconds if they have a fraction, else that in
// which all are dates after 2001, or else, for numbers from 1e9 on, that in which one follows the
// other by a millisecond or more. nullopt if they may as well be counters.
std::optional<StampUnit> unit_of_stamps(std::span<const std::string> numbers);

}  // namespace divemesh::recording
