#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/dive/finding_log.hpp"

// A clock that was set back while a dive was recorded: all tables go on with earlier timestamps.
namespace divemesh::dive {

// Returns true if the timestamps, in the order of the file, look like those of a clock that was set
// back: a few long rising runs, each of which begins within the time of the run before. Rows in any
// other order are unsorted.
bool is_set_back(const std::vector<std::int64_t>& timestamps_ns);

// A table's timestamps, in the order of its file.
struct TableStamps {
    std::string file;
    std::vector<std::int64_t*> timestamps_ns;
};

// Moves all timestamps after a step back forward, by the same time in all tables, so that each
// table goes on where it was: the order of the rows is believed. The step is taken from the table
// that shows it best. Reports a warning, or an error if the tables differ in the number of their
// steps.
void undo_set_backs(std::vector<TableStamps>& tables, FindingLog& findings);

}  // namespace divemesh::dive
