#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <unordered_map>

#include "schemas/error.hpp"

namespace divemesh::api {

// What a refused client is told (draft-ietf-httpapi-ratelimit-headers): how much it may do in which
// time, and when it may continue.
struct RateAdvice {
    std::string policy;  // its name: "token", "address"
    std::int64_t quota = 0;
    std::int64_t window_s = 0;
    std::int64_t wait_s = 0;
};

// Thrown for a request that exceeds a rate limit, with the advice for the client.
class TooOften : public Error {
public:
    TooOften(const std::string& message, RateAdvice advice)
        : Error(ErrorCode::TooMany, message), advice_(std::move(advice)) {}
    const RateAdvice& advice() const { return advice_; }

private:
    RateAdvice advice_;
};

// Token buckets: each key may do `per_second` requests a second on average and `burst` at once.
// Keys that have been quiet are forgotten; when too many keys are busy, all buckets are reset.
// Thread-safe.
class RateLimiter {
public:
    using Clock = std::chrono::steady_clock;

    RateLimiter(double per_second, double burst) : per_second_(per_second), burst_(burst) {}

    // Returns false if there were too many. A rate of 0 means no limit.
    bool allow(const std::string& key, Clock::time_point now = Clock::now());
    // Returns the advice for a key that allow() has just refused.
    RateAdvice advice(const std::string& policy) const;

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
