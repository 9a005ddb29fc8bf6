#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <utility>

namespace divemesh::sensor {

// What a link carries, from when the other end says that it got what was sent: the most of the last
// seconds, as the link is idle most of the time. Each sample is over the whole way of one message
// (Cheng et al., "Delivery Rate Estimation"), so that answers that come in a bunch do not make it
// look faster.
class RateMeter {
public:
    using Clock = std::chrono::steady_clock;

    // What had been answered for when a message went out.
    struct Stamp {
        std::int64_t num_bytes = 0;
        Clock::time_point at;
    };

    // `is_idle`: nothing else is under way.
    Stamp sent(Clock::time_point now, bool is_idle);
    // `num_bytes` were answered for, the last message of which went out at `last`.
    void answered(Clock::time_point now, const Stamp& last, std::int64_t num_bytes);
    double bytes_per_s(Clock::time_point now) const;  // 0: not known

private:
    Stamp answered_;
    std::deque<std::pair<Clock::time_point, double>> samples_;
};

}  // namespace divemesh::sensor
