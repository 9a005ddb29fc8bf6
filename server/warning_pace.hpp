#pragma once

#include <chrono>
#include <optional>
#include <utility>

namespace divemesh::server {

// Lets one warning through in each interval and counts the others, so that a fault that repeats
// many times a second does not fill the log.
class WarningPace {
public:
    using Clock = std::chrono::steady_clock;

    explicit WarningPace(std::chrono::milliseconds every) : every_(every) {}

    // Returns how many warnings were left out before this one; nullopt: leave this one out too.
    std::optional<int> pass(Clock::time_point now) {
        if (last_ && now - *last_ < every_) {
            ++num_left_out_;
            return std::nullopt;
        }
        last_ = now;
        return std::exchange(num_left_out_, 0);
    }

private:
    std::chrono::milliseconds every_;
    std::optional<Clock::time_point> last_;
    int num_left_out_ = 0;
};

}  // namespace divemesh::server
