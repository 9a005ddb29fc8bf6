#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "worker/dive/clock_steps.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// The clock that the tables of a dive share: they are moved by the same shifts, so that cameras and
// IMU stay together. Read the table with the most rows a second first, as it shows steps best.
class CommonClock {
public:
    explicit CommonClock(FindingLog& findings) : findings_(findings) {}

    // Returns the clock of the first table that was set back; it has no steps if none was.
    const TableClock& known() const { return known_; }
    // Adds a table that was moved by the shifts of `clock`, found with known(). Reports where a
    // clock was set back and how rows were moved, and tables that contradict the known clock.
    void add(const std::string& file, const TableClock& clock);

private:
    void report_contradiction(const std::string& file);

    FindingLog& findings_;
    TableClock known_;
    std::string known_file_;
    std::vector<std::pair<std::string, TableClock>> earlier_;  // files and clocks without steps
};

// Reports where frames pause for more than ten seconds: with the IMU pausing too, the clock was set
// forward or the recorder stopped; without, the cameras stopped.
void report_pauses(const std::vector<std::int64_t>& frames_ns,
                   const std::vector<types::ImuSample>& imu,
                   FindingLog& findings);

}  // namespace divemesh::dive
