#include "worker/pipeline/unusable_pair_log.hpp"

#include <gtest/gtest.h>

namespace divemesh::pipeline {
namespace {

constexpr std::int64_t kPeriod_ns = 100'000'000;

std::vector<types::UnusablePairs> runs_of(const std::vector<std::int64_t>& usable,
                                          std::int64_t num_pairs) {
    UnusablePairLog log;
    for (const std::int64_t index : usable) log.add_frame(index, kPeriod_ns * index);
    return log.finish(num_pairs);
}

TEST(UnusablePairLogTest, NotesRunsWithinTheDiveAndAtItsEnds) {
    const auto runs = runs_of({5, 6, 7, 20, 21}, 52);
    ASSERT_EQ(runs.size(), 3U);
    EXPECT_EQ(runs[0].first, 0);
    EXPECT_EQ(runs[0].num, 5);
    EXPECT_EQ(runs[0].next_frame, 0);
    EXPECT_NEAR(runs[0].duration_s, 0.5, 1e-9);
    EXPECT_EQ(runs[1].first, 8);
    EXPECT_EQ(runs[1].num, 12);
    EXPECT_EQ(runs[1].next_frame, 3);
    EXPECT_NEAR(runs[1].duration_s, 1.3, 1e-9);
    EXPECT_EQ(runs[2].first, 22);
    EXPECT_EQ(runs[2].num, 30);
    EXPECT_EQ(runs[2].next_frame, 5);
    EXPECT_NEAR(runs[2].duration_s, 3.0, 1e-9);
}

TEST(UnusablePairLogTest, ADiveWhoseFramesAllServeHasNone) {
    EXPECT_TRUE(runs_of({0, 1, 2}, 3).empty());
}

TEST(UnusablePairLogTest, OneFrameOrNoneTellsNoTime) {
    ASSERT_EQ(runs_of({0}, 10).size(), 1U);
    EXPECT_EQ(runs_of({0}, 10)[0].duration_s, 0.0);
    ASSERT_EQ(runs_of({}, 10).size(), 1U);
    EXPECT_EQ(runs_of({}, 10)[0].num, 10);
}

}  // namespace
}  // namespace divemesh::pipeline
