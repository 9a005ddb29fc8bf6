#include "api/rate_limiter.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxKeys = 10'000;

}  // namespace

bool RateLimiter::allow(const std::string& key, Clock::time_point now) {
    if (per_second_ <= 0.0) return true;
    const std::lock_guard lock(mutex_);
    if (buckets_.size() >= kMaxKeys && !buckets_.contains(key)) {
        const auto full = [&](const auto& entry) {
            const std::chrono::duration<double> quiet = now - entry.second.since;
            return entry.second.left + quiet.count() * per_second_ >= burst_;
        };
        std::erase_if(buckets_, full);
        if (buckets_.size() >= kMaxKeys) buckets_.clear();
    }
    auto& bucket = buckets_.try_emplace(key, Bucket{burst_, now}).first->second;
    const std::chrono::duration<double> passed = now - bucket.since;
    bucket.left = std::min(burst_, bucket.left + passed.count() * per_second_);
    bucket.since = now;
    if (bucket.left < 1.0) return false;
    bucket.left -= 1.0;
    return true;
}

// A refused client has less than one request left, and waits for one at most.
RateAdvice RateLimiter::advice(const std::string& policy) const {
    const auto whole = [](double value) { return static_cast<std::int64_t>(std::ceil(value)); };
    return {policy,
            static_cast<std::int64_t>(std::max(burst_, 1.0)),
            whole(burst_ / per_second_),
            whole(1.0 / per_second_)};
}

}  // namespace divemesh::api
