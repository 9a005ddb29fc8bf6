#include "api/idempotency.hpp"

#include <gtest/gtest.h>

namespace divemesh::api {
namespace {

TEST(KeysInFlightTest, AKeyIsOneRequestsAloneUntilItEnds) {
    KeysInFlight keys;
    auto first = keys.enter("a");
    EXPECT_TRUE(first);
    EXPECT_FALSE(keys.enter("a"));
    EXPECT_TRUE(keys.enter("b"));
    first.reset();
    EXPECT_TRUE(keys.enter("a"));
}

}  // namespace
}  // namespace divemesh::api
