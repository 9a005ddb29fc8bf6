#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <utility>

namespace divemesh::sensor {

// Measures the rate of a link from the time at which the other end acknowledges bytes: the max of
// the last seconds, because the link is idle most of the time. Each sample spans the whole way of
// one message (Cheng et al., "Delivery Rate Estimation"), so that acknowledgements in a bunch do
// not exaggerate the rate.
class RateMeter {
public:
    using Clock = std::chrono::steady_clock;

    // What had been acknowledged when a message was sent.
    struct Stamp {
        std::int64_t num_bytes = 0;
        Clock::time_point at;
    };

    // `is_idle`: no other message is under way.
    Stamp sent(Clock::time_point now, bool is_idle);
    // Records that `num_bytes` were acknowledged; the last message of them was sent at `last`.
    void answered(Clock::time_point now, const Stamp& last, std::int64_t num_bytes);
    double bytes_per_s(Clock::time_point now) const;  // 0: unknown

private:
    Stamp answered_;
    std::deque<std::pair<Clock::time_point, double>> samples_;
};

}  // namespace divemesh::sensor
