#include "worker/simulator/stretch.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::simulator {
namespace {

TEST(StretchTest, ReadsWhereEachBeginsAndHowLongItTakes) {
    const auto stretches = stretches_from_string("0:10,0.5:2.5");
    ASSERT_EQ(stretches.size(), 2U);
    EXPECT_EQ(stretches[0].at_share, 0.0);
    EXPECT_EQ(stretches[0].duration_s, 10.0);
    EXPECT_EQ(stretches[1].at_share, 0.5);
    EXPECT_EQ(stretches[1].duration_s, 2.5);
    EXPECT_TRUE(stretches_from_string("").empty());
}

TEST(StretchTest, RefusesWhatIsNoStretchAndWhatIsOutOfOrder) {
    for (const char* text : {"5", "0.5", "a:3", "0:3s", "1.5:3", "-0.1:3", "0:0", "0.5:1,0.2:1"})
        EXPECT_THROW(stretches_from_string(text), Error) << text;
}

}  // namespace
}  // namespace divemesh::simulator
