#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "worker/dive/clock_steps.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// A table whose clock was set back, already moved by the shifts of `clock`.
struct SteppedTable {
    std::string file;
    TableClock clock;
    // Adds `shift_ns` to all timestamps from `from_ns` on.
    std::function<void(std::int64_t from_ns, std::int64_t shift_ns)> move;
};

// Gives tables of one clock the same shifts, those of the table with the most rows a second, so
// that cameras and IMU stay together. Reports where the clock was set back and how rows were moved.
void join_clocks(const std::vector<SteppedTable>& tables, FindingLog& findings);

// Reports where frames pause for more than ten seconds: with the IMU pausing too, the clock was set
// forward or the recorder stopped; without, the cameras stopped.
void report_pauses(const std::vector<std::int64_t>& frames_ns,
                   const std::vector<types::ImuSample>& imu,
                   FindingLog& findings);

}  // namespace divemesh::dive
