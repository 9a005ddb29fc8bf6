#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "worker/recording/stamp_unit.hpp"

namespace divemesh::recording {

// A table of another program as divemesh writes tables.
struct TimeTable {
    std::string csv;           // rows: the time in whole nanoseconds, then the fields behind it
    std::string unit;          // that the times had, for people
    bool has_fraction = true;  // false: the times were whole seconds
};

// Converts a table in which a time comes before what was recorded then: separated by commas,
// semicolons, tabs or blanks, with or without a heading, comments, an index in front, a byte order
// mark or CRLF. Times are whole numbers (see unit_of_stamps), seconds with a fraction, or dates. A
// unit that is `stated` is used instead of the one that the numbers suggest. nullopt if no column
// holds times.
std::optional<TimeTable> convert_time_table(std::string_view text, std::optional<StampUnit> stated);

}  // namespace divemesh::recording
