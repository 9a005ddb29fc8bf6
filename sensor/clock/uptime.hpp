#pragma once

#include <cstdint>

namespace divemesh::sensor {

// Returns the milliseconds since this program started, by a clock that is never set and that runs
// on while the machine sleeps.
std::int64_t uptime_ms();

// Returns whether a source (NTP, a GPS receiver) keeps the machine's clock right.
bool is_wall_time_synchronised();

}  // namespace divemesh::sensor
