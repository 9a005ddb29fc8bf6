#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <unordered_map>

namespace divemesh::api {

// Token buckets: each key may do `per_second` things a second on average and `burst` at once. Keys
// that have been quiet are forgotten; when too many are busy, all start anew. Thread-safe.
class RateLimiter {
public:
    using Clock = std::chrono::steady_clock;

    RateLimiter(double per_second, double burst) : per_second_(per_second), burst_(burst) {}

    // False: too many. A rate of 0 limits nothing.
    bool allow(const std::string& key, Clock::time_point now = Clock::now());

private:
    struct Bucket {
        double left;
        Clock::time_point since;
    };
    double per_second_;
    double burst_;
    std::mutex mutex_;
    std::unordered_map<std::string, Bucket> buckets_;
};

}  // namespace divemesh::api
