#include "cli/text.hpp"

#include <gtest/gtest.h>

namespace divemesh::cli {
namespace {

TEST(TextTest, WritesBytesWithTheirUnit) {
    EXPECT_EQ(bytes_text(0), "0 B");
    EXPECT_EQ(bytes_text(999), "999 B");
    EXPECT_EQ(bytes_text(1000), "1.0 kB");
    EXPECT_EQ(bytes_text(12'345'678), "12.3 MB");
    EXPECT_EQ(bytes_text(5e15), "5000.0 TB");
}

TEST(TextTest, WritesDurationsAsAClockDoes) {
    EXPECT_EQ(duration_text(0), "0:00");
    EXPECT_EQ(duration_text(59.6), "1:00");
    EXPECT_EQ(duration_text(725), "12:05");
    EXPECT_EQ(duration_text(3723), "1:02:03");
    EXPECT_EQ(duration_text(-1), "0:00");
}

TEST(TextTest, MakesColumnsAsWideAsTheirLongestCell) {
    EXPECT_EQ(table_text({{"ID", "STATE"}, {"longer", "x"}, {"a"}}),
              "ID      STATE\n"
              "longer  x\n"
              "a\n");
}

}  // namespace
}  // namespace divemesh::cli
