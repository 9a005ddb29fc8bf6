#include "api/rate_limiter.hpp"

#include <gtest/gtest.h>

namespace divemesh::api {
namespace {

using namespace std::chrono_literals;

TEST(RateLimiterTest, AllowsABurstAndThenTheRate) {
    RateLimiter limiter(2.0, 4.0);
    const auto start = RateLimiter::Clock::now();
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(limiter.allow("laptop", start));
    EXPECT_FALSE(limiter.allow("laptop", start));
    EXPECT_TRUE(limiter.allow("boat", start));
    EXPECT_TRUE(limiter.allow("laptop", start + 500ms));
    EXPECT_FALSE(limiter.allow("laptop", start + 500ms));
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(limiter.allow("laptop", start + 1h));
    EXPECT_FALSE(limiter.allow("laptop", start + 1h));
}

TEST(RateLimiterTest, RemembersABoundedNumberOfKeys) {
    RateLimiter limiter(1.0, 1.0);
    const auto start = RateLimiter::Clock::now();
    EXPECT_TRUE(limiter.allow("mine", start));
    for (int i = 0; i < 9'999; ++i) limiter.allow(std::to_string(i), start);
    EXPECT_FALSE(limiter.allow("mine", start + 500ms));
    EXPECT_TRUE(limiter.allow("another", start + 2s));
}

TEST(RateLimiterTest, ARateOfZeroLimitsNothing) {
    RateLimiter limiter(0.0, 0.0);
    for (int i = 0; i < 100; ++i) EXPECT_TRUE(limiter.allow("x"));
}

}  // namespace
}  // namespace divemesh::api
