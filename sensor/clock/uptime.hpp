#pragma once

#include <cstdint>

namespace divemesh::sensor {

// Milliseconds since this program was started, by a clock that nobody sets and that goes on while
// the machine sleeps.
std::int64_t uptime_ms();

// By the machine's own clock, which may be wrong; unix.
std::int64_t wall_time_ms();

// Whether something (NTP, a GPS receiver) keeps the machine's clock right.
bool is_wall_time_synchronised();

}  // namespace divemesh::sensor
