#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace divemesh::dive {

// A clock that was set back while a table was written: the rows from `first_row` on have earlier
// timestamps than rows before, though they were recorded later.
struct ClockStep {
    std::size_t first_row = 0;
    std::int64_t last_before_ns = 0;  // as written, the latest of the rows before
    std::int64_t first_after_ns = 0;  // as written, of `first_row`
    std::int64_t shift_ns = 0;        // to add to the rows from `first_row` on, all steps included
};

// Where the clock of one table was set back.
struct TableClock {
    std::int64_t period_ns = 0;
    std::vector<ClockStep> steps;
    std::int64_t first_ns = 0;  // as written, of the first and the last row
    std::int64_t last_ns = 0;
    bool is_known = false;  // the steps are those of a clock that another table has shown
};

// Tells a clock that was set back from rows that are merely out of order. Out of order: rows that
// fill gaps of the rows before, a few rows that repeat their timestamps, or blocks in the wrong
// order that continue each other; they do not hide a step elsewhere. The shift of a step lets its
// first row follow the rows before after one period, as nothing is known of a longer pause.
// `timestamps_ns` are in the order of the file.
TableClock find_clock_steps(std::span<const std::int64_t> timestamps_ns);

// Finds the steps of a known clock in another table, with the shifts that are known: one row on a
// side is enough, and a step may be shorter than the period. A table may begin after a step or end
// before it. Returns the table's own steps if it contradicts the known clock, or none is known.
TableClock find_clock_steps(std::span<const std::int64_t> timestamps_ns, const TableClock& known);

}  // namespace divemesh::dive
