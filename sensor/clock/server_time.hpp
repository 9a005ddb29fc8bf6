#pragma once

#include <cstdint>

namespace divemesh::sensor {

// The server's clock, as far as a device knows it from the welcome and its own uptime.
struct ServerTime {
    std::int64_t time_ms = 0;             // unix, in the welcome
    std::int64_t asked_at_uptime_ms = 0;  // before that: it cannot have been later
    std::int64_t heard_at_uptime_ms = 0;

    // Between these it is now there.
    std::int64_t earliest_ms(std::int64_t uptime) const {
        return time_ms + uptime - heard_at_uptime_ms;
    }
    std::int64_t latest_ms(std::int64_t uptime) const {
        return time_ms + uptime - asked_at_uptime_ms;
    }
};

}  // namespace divemesh::sensor
