#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>

namespace divemesh::api::client {

// Limits senders to so many bytes per second in total; zero: no limit. A pause does not earn a
// later burst. Thread-safe.
class RateLimiter {
public:
    explicit RateLimiter(double max_bytes_per_s) : max_bytes_per_s_(max_bytes_per_s) {}

    void sent(std::int64_t num_bytes);  // sleeps until the limit allows them

private:
    using Clock = std::chrono::steady_clock;

    double max_bytes_per_s_;
    std::mutex mutex_;
    Clock::time_point free_at_ = Clock::now();
};

}  // namespace divemesh::api::client
