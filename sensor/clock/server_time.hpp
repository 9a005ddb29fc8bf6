#pragma once

#include <cstdint>

namespace divemesh::sensor {

// The server's clock, as a device knows it from the welcome message and its own uptime.
struct ServerTime {
    std::int64_t time_ms = 0;             // unix, from the welcome message
    std::int64_t asked_at_uptime_ms = 0;  // of the request: time_ms is not earlier
    std::int64_t heard_at_uptime_ms = 0;

    // Return the bounds of the server's current time, unix milliseconds.
    std::int64_t earliest_ms(std::int64_t uptime) const {
        return time_ms + uptime - heard_at_uptime_ms;
    }
    std::int64_t latest_ms(std::int64_t uptime) const {
        return time_ms + uptime - asked_at_uptime_ms;
    }
};

}  // namespace divemesh::sensor
