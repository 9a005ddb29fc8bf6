#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <utility>

namespace divemesh::sensor {

// What a link carries, from the times at which the other end had got what was sent: the most of the
// last seconds, as the link is idle most of the time.
class RateMeter {
public:
    using Clock = std::chrono::steady_clock;

    // `num_bytes` were answered for, the first of which went out at `sent_at`.
    void answered(Clock::time_point now, Clock::time_point sent_at, std::int64_t num_bytes);
    double bytes_per_s(Clock::time_point now) const;  // 0: not known

private:
    Clock::time_point last_answer_at_ = {};
    std::deque<std::pair<Clock::time_point, double>> samples_;
};

}  // namespace divemesh::sensor
