#include "api/client/rate_limiter.hpp"

#include <algorithm>
#include <thread>

namespace divemesh::api::client {

void RateLimiter::sent(std::int64_t num_bytes) {
    if (max_bytes_per_s_ <= 0.0) return;
    const std::chrono::duration<double> takes(static_cast<double>(num_bytes) / max_bytes_per_s_);
    Clock::time_point until;
    {
        const std::lock_guard lock(mutex_);
        free_at_ =
            std::max(free_at_, Clock::now()) + std::chrono::duration_cast<Clock::duration>(takes);
        until = free_at_;
    }
    std::this_thread::sleep_until(until);
}

}  // namespace divemesh::api::client
