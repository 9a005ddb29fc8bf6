#include "schemas/crc32c.hpp"

#include <gtest/gtest.h>

#include <string>

namespace divemesh {
namespace {

TEST(Crc32cTest, GivesWhatTheRfcHas) {
    EXPECT_EQ(crc32c("123456789"), 0xE3069283);
    EXPECT_EQ(crc32c(std::string(32, '\0')), 0x8A9136AA);
    EXPECT_EQ(crc32c(""), 0u);
}

}  // namespace
}  // namespace divemesh
